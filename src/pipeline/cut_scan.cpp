// SPDX-License-Identifier: Apache-2.0
#include "pipeline/cut_scan.hpp"

#include <algorithm>

#include "pipeline/part_rows.hpp"
#include "store/files.hpp"
#include "verify/verify.hpp"

namespace scanmill::pipeline {
namespace {

struct Kind {
  std::string name;
  bool is_one;  // task, for the whole scan
  std::size_t row_bytes;
};
/// In the order of PartStage. Rows of a byte: lists of several kinds.
const Kind kKinds[] = {{"map", false, sizeof(TotalRow)},
                       {"gather", true, sizeof(TotalRow)},
                       {"frame", false, sizeof(FrameRow)},
                       {"pick", false, sizeof(PickRow)},
                       {"points", true, sizeof(PointRow)},
                       {"thin", false, sizeof(ThinRow)},
                       {"settle", true, sizeof(reduce::Drop)},
                       {"stars", false, 1},
                       {"mesh", true, 1},
                       {"swap", false, 1},
                       {"join", true, 1},
                       {"verify", false, sizeof(verify::PieceVerdict::Vertex)}};

}  // namespace

std::string name_of(const PartTask& task) {
  const Kind& kind = kKinds[static_cast<std::size_t>(task.stage)];
  return kind.is_one ? kind.name : kind.name + (" " + std::to_string(task.number));
}

std::string link_name(std::uint32_t piece) { return "link " + std::to_string(piece); }

PartKind kind_of(const Cut& cut, std::string name, std::size_t row_bytes) {
  return {cut.identity, std::move(name), row_bytes};
}

std::string path_of(const Cut& cut, std::string name) {
  std::replace(name.begin(), name.end(), ' ', '-');
  return cut.folder + "/" + name + ".part";
}

std::optional<PartFile> open_part(const Cut& cut, const PartTask& task) {
  const std::string name = name_of(task);
  return PartFile::open(path_of(cut, name), kind_of(cut, name, kKinds[static_cast<std::size_t>(task.stage)].row_bytes));
}

Result<PartFile> need_part(const Cut& cut, const PartTask& task) {
  if (auto file = open_part(cut, task)) return *std::move(file);
  return fail(Code::IoFailed, "is not there or another run's; the task '" + name_of(task) + "' makes it",
              path_of(cut, name_of(task)));
}

Result<PartWriter> create_part(const Cut& cut, const PartTask& task) {
  const std::string name = name_of(task);
  return PartWriter::create(path_of(cut, name),
                            kind_of(cut, name, kKinds[static_cast<std::size_t>(task.stage)].row_bytes));
}

namespace {

void add_wave(std::vector<std::vector<PartTask>>& waves, PartStage stage, std::uint32_t count) {
  waves.emplace_back();
  for (std::uint32_t n = 0; n < count; ++n) waves.back().push_back({stage, n});
}

}  // namespace

std::vector<std::vector<PartTask>> waves_of(const Cut& cut, reduce::Representative representative) {
  std::vector<std::vector<PartTask>> waves;
  add_wave(waves, PartStage::Map, cut.pieces);
  add_wave(waves, PartStage::Gather, 1);
  add_wave(waves, PartStage::Frame, cut.batches);
  if (representative == reduce::Representative::Surface) add_wave(waves, PartStage::Pick, cut.pieces);
  add_wave(waves, PartStage::Points, 1);
  add_wave(waves, PartStage::Thin, cut.batches);
  add_wave(waves, PartStage::Settle, 1);
  return waves;
}

std::vector<std::vector<PartTask>> scan_waves(const Cut& cut, const What& what) {
  auto waves = waves_of(cut, what.reduce.representative);
  if (what.grow.engine != Engine::Front) add_wave(waves, PartStage::Stars, cut.batches);
  add_wave(waves, PartStage::Mesh, 1);
  add_wave(waves, PartStage::Swap, cut.batches);
  add_wave(waves, PartStage::Join, 1);
  add_wave(waves, PartStage::Verify, verify_tasks(cut));
  return waves;
}

std::uint32_t verify_tasks(const Cut& cut) {
  constexpr std::uint32_t kLeast = 4, kPieces = 4;
  return std::max(std::min(cut.pieces, kLeast), (cut.pieces + kPieces - 1) / kPieces);
}

bool wants_whole(PartStage stage) {
  return stage == PartStage::Settle || stage == PartStage::Mesh || stage >= PartStage::Join;
}

namespace {

/// The task after which a stage's parts have no reader.
std::optional<PartTask> last_reader(PartStage stage) {
  switch (stage) {
    case PartStage::Map:
    case PartStage::Frame:
    case PartStage::Pick:
      return PartTask{PartStage::Points, 0};
    case PartStage::Thin:
      return PartTask{PartStage::Settle, 0};
    case PartStage::Stars:
      return PartTask{PartStage::Mesh, 0};
    case PartStage::Mesh:
    case PartStage::Swap:
      return PartTask{PartStage::Join, 0};
    default:
      return std::nullopt;
  }
}

}  // namespace

bool is_done(const Cut& cut, const PartTask& task) {
  if (open_part(cut, task)) {
    if (task.stage != PartStage::Gather || open_part(cut, {PartStage::Points, 0})) return true;
    for (std::uint32_t n = 0; n < cut.pieces; ++n)
      if (!PartFile::open(path_of(cut, link_name(n)), kind_of(cut, link_name(n), sizeof(std::uint64_t)))) return false;
    return true;
  }
  const auto reader = last_reader(task.stage);
  if (!reader || !is_done(cut, *reader)) return false;
  // Points are read together with what `gather` made of the pieces: should that be lost, the pieces are wanted again.
  return reader->stage != PartStage::Points || open_part(cut, {PartStage::Gather, 0}).has_value();
}

void remove_read_parts(const Cut& cut, PartStage made) {
  for (auto n = static_cast<std::uint8_t>(PartStage::Map); n <= static_cast<std::uint8_t>(PartStage::Verify); ++n) {
    const auto stage = static_cast<PartStage>(n);
    if (const auto reader = last_reader(stage); !reader || reader->stage != made) continue;
    const std::uint32_t count = kKinds[static_cast<std::size_t>(stage)].is_one ? 1 : std::max(cut.pieces, cut.batches);
    for (std::uint32_t number = 0; number < count; ++number) {
      (void)store::remove_tree(path_of(cut, name_of({stage, number})));
      if (stage == PartStage::Map) (void)store::remove_tree(path_of(cut, link_name(number)));
    }
  }
}

}  // namespace scanmill::pipeline
