// SPDX-License-Identifier: Apache-2.0
#include "pipeline/part_forecast.hpp"

#include <algorithm>

#include "cloud/over_blocks.hpp"
#include "cloud/piece.hpp"
#include "pipeline/bin_forecast.hpp"
#include "pipeline/part_rows.hpp"
#include "verify/verify.hpp"

namespace scanmill::pipeline {
namespace {

/// Points up to which every bin is counted; of more a share tells enough.
constexpr std::uint64_t kCountedPoints = 2000000;
// Of a part beside its rows: head, text, checksums, the last block, and what it took.
constexpr std::uint64_t kFileBytes = 12 << 10;
// Lists a bin, measured where nearly every bin keeps its point: 33 bytes of stars, 76 of a mesh.
constexpr std::uint64_t kStarBytes = 40, kMeshBytes = 80;
// Of a result: record and page, and what does not grow.
constexpr std::uint64_t kResultBytes = 90;
constexpr std::uint64_t kPictureBytes = 4 << 20;

/// Bytes of a mesh file a bin, two triangles each; measured.
std::uint64_t file_bytes(const Output& output) {
  if (output.format == "stl") return output.ascii ? 440 : 100;
  if (output.format == "iges") return 3600;
  if (output.format == "dxf") return 600;
  return output.format == "obj" ? 110 : 60;
}

/// Bytes of all the parts that a wave makes.
std::uint64_t rows_of(PartStage stage, const BinCounts& bins) {
  switch (stage) {
    case PartStage::Map:
      return bins.of_pieces * sizeof(TotalRow);
    case PartStage::Gather:  // with the links
      return bins.of_all * sizeof(TotalRow) + bins.of_pieces * sizeof(std::uint64_t);
    case PartStage::Frame:
      return bins.of_all * sizeof(FrameRow);
    case PartStage::Pick:
      return bins.of_pieces * sizeof(PickRow);
    case PartStage::Points:
      return bins.of_all * sizeof(PointRow);
    case PartStage::Thin:
      return bins.of_all * sizeof(ThinRow);
    case PartStage::Settle:
      return bins.of_all * sizeof(reduce::Drop);
    case PartStage::Stars:
      return bins.of_all * kStarBytes;
    case PartStage::Verify:
      return bins.of_pieces * sizeof(verify::PieceVerdict::Vertex);
    default:
      return bins.of_all * kMeshBytes;
  }
}

/// What remove_read_parts takes away once `made` is there, or less.
std::uint64_t rows_read_by(PartStage made, const BinCounts& bins) {
  switch (made) {
    case PartStage::Points:
      return rows_of(PartStage::Map, bins) + bins.of_pieces * sizeof(std::uint64_t) + rows_of(PartStage::Frame, bins);
    case PartStage::Settle:
      return rows_of(PartStage::Thin, bins);
    case PartStage::Join:
      return rows_of(PartStage::Mesh, bins) + rows_of(PartStage::Swap, bins);
    default:
      return 0;
  }
}

/// CPU time in nanoseconds, measured with 10 million points in 160,000 bins and 4 pieces; what counts is their
/// proportion.
struct Cost {
  double point = 0, bin = 0;
  double task_bin = 0;  // a bin of the whole for every task of verification
};
Cost cost_of(PartStage stage) {
  switch (stage) {
    case PartStage::Map:
    case PartStage::Pick:
      return {30, 0, 0};
    case PartStage::Gather:
      return {0, 1000, 0};
    case PartStage::Frame:
      return {0, 1400, 0};
    case PartStage::Points:
      return {0, 450, 0};
    case PartStage::Thin:
      return {0, 1800, 0};
    case PartStage::Settle:
      return {0, 50, 0};
    case PartStage::Swap:
      return {0, 5500, 0};
    case PartStage::Join:
      return {0, 900, 0};
    case PartStage::Verify:
      return {200, 0, 2000};
    default:
      return {0, 2200, 0};
  }
}
constexpr Cost kCount{35, 0, 0}, kFinish{10, 4500, 0};

double in(const Cost& cost, const BinCounts& bins, const Cut& cut) {
  return cost.point * static_cast<double>(bins.points) +
         (cost.bin + cost.task_bin * verify_tasks(cut)) * static_cast<double>(bins.of_all);
}

PartKind counts_kind(const Cut& cut) { return kind_of(cut, "inputs", sizeof(BinCounts)); }

}  // namespace

Result<BinCounts> count_bins(const PointSource& points, const What& what, const Cut& cut, const Context& context) {
  TRY_ASSIGN(const reduce::LocalFrame frame, reduce::frame_of_parts(points, what.lattice, what.reduce));
  BinCounts counts{points.expected_points(), 0, 0};
  const auto one_in = static_cast<int>(counts.points / kCountedPoints + 1);
  const int threads = context.loop.threads();
  BinForecast all(frame, 1, one_in);
  for (std::uint32_t piece = 0; piece < cut.pieces; ++piece) {
    BinForecast some(frame, threads, one_in);
    TRY(over_blocks(PiecePoints(points, piece, cut.pieces), context,
                    [&](int worker, const PointBlock& block) -> Result<void> {
                      some.look(worker, block);
                      return {};
                    }));
    counts.of_pieces += some.bins();
    all.add(some);
  }
  counts.of_all = all.bins();
  if (one_in == 1) return counts;
  counts.of_pieces += counts.of_pieces / 10;
  counts.of_all += counts.of_all / 10;
  return counts;
}

std::vector<WaveForecast> forecast_waves(const Cut& cut, const What& what, const BinCounts& bins) {
  const auto waves = scan_waves(cut, what);
  const bool is_picked = what.reduce.representative == reduce::Representative::Surface;
  std::vector<WaveForecast> forecast{{kFileBytes, in(kCount, bins, cut)}};
  std::uint64_t there = forecast[0].disk;
  for (const auto& wave : waves) {
    const PartStage stage = wave.front().stage;
    there += rows_of(stage, bins) + wave.size() * kFileBytes;
    if (stage == PartStage::Gather) there += cut.pieces * kFileBytes;
    forecast.push_back({there, in(cost_of(stage), bins, cut)});
    there -= rows_read_by(stage, bins);
    if (stage == PartStage::Points && is_picked) there -= rows_of(PartStage::Pick, bins);
  }
  std::uint64_t result_bytes = kResultBytes;
  for (const Output& output : what.outputs) result_bytes += file_bytes(output);
  forecast.push_back({there + kPictureBytes + bins.of_all * result_bytes, in(kFinish, bins, cut)});
  double cost = 0;
  for (const WaveForecast& wave : forecast) cost += wave.cpu;
  for (WaveForecast& wave : forecast) {
    wave.cpu /= cost;
    wave.disk += wave.disk / 100;  // checksums, tables of bricks
  }
  return forecast;
}

std::optional<BinCounts> kept_counts(const Cut& cut) {
  const auto file = PartFile::open(path_of(cut, "inputs"), counts_kind(cut));
  BinCounts bins;
  if (!file || file->rows() != 1 || !file->read_rows(0, std::span(&bins, 1))) return std::nullopt;
  return bins;
}

Result<void> keep_counts(const Cut& cut, const BinCounts& bins) {
  TRY_ASSIGN(PartWriter writer, PartWriter::create(path_of(cut, "inputs"), counts_kind(cut)));
  TRY(writer.add_rows(std::span<const BinCounts>(&bins, 1)));
  return writer.commit();
}

}  // namespace scanmill::pipeline
