// SPDX-License-Identifier: Apache-2.0
#include "pipeline/cut_surface.hpp"

#include <cstring>
#include <type_traits>
#include <utility>

#include "cloud/piece.hpp"

namespace scanmill::pipeline {
namespace {

/// Values one after the other, as they stand in memory; a list begins with its length.
class Keeper {
 public:
  explicit Keeper(PartWriter& writer) : writer_(writer) {}
  template <class... Values>
  void operator()(const Values&... values) {
    (keep(values), ...);
  }
  Result<void> state = {};

 private:
  template <class T>
  void keep(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    bytes(&value, sizeof value);
  }
  template <class T>
  void keep(const std::vector<T>& list) {
    keep(static_cast<std::uint64_t>(list.size()));
    if constexpr (std::is_trivially_copyable_v<T>)
      bytes(list.data(), list.size() * sizeof(T));
    else
      for (const T& value : list) keep(value);
  }
  void keep(const BorderLoop& loop) { (*this)(loop.vertices, loop.length_mm, loop.centre); }
  void bytes(const void* begin, std::size_t count) {
    if (state.ok() && count > 0) state = writer_.add({static_cast<const char*>(begin), count});
  }
  PartWriter& writer_;
};

/// The same back.
class Taker {
 public:
  explicit Taker(const PartFile& file) : file_(file) {}
  template <class... Values>
  void operator()(Values&... values) {
    (take(values), ...);
  }
  Result<void> state = {};

 private:
  template <class T>
  void take(T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    bytes(&value, sizeof value);
  }
  template <class T>
  void take(std::vector<T>& list) {
    std::uint64_t count = 0;
    take(count);
    if (count > file_.rows() - at_) state = fail(Code::IoFailed, "is shorter than its lists; remove it and run again");
    if (!state.ok()) return;
    list.resize(static_cast<std::size_t>(count));
    if constexpr (std::is_trivially_copyable_v<T>)
      bytes(list.data(), list.size() * sizeof(T));
    else
      for (T& value : list) take(value);
  }
  void take(BorderLoop& loop) { (*this)(loop.vertices, loop.length_mm, loop.centre); }
  void bytes(void* begin, std::size_t count) {
    if (!state.ok() || count == 0) return;
    state = file_.read(at_, {static_cast<char*>(begin), count});
    at_ += count;
  }
  const PartFile& file_;
  std::uint64_t at_ = 0;
};

/// What distances are measured against, for either direction; the index follows from the bins.
template <class Store, class Made>
void store_judged(Store& store, Made& made) {
  auto& cloud = made.reduction.cloud;
  auto& surface = made.surface;
  store(cloud.lattice, cloud.base, cloud.bins);
  store(surface.mesh.positions, surface.mesh.triangles, surface.mesh.patch, surface.mesh.offset, surface.vertex_row,
        surface.stray_rows);
}

template <class Store, class Made>
void store_rest(Store& store, Made& made) {
  auto& cloud = made.reduction.cloud;
  auto& surface = made.surface;
  auto& patches = surface.patches;
  store(cloud.measured, cloud.source, cloud.counts, cloud.drop, cloud.projected, cloud.normal, cloud.residual,
        cloud.variation, cloud.plane_distance, cloud.frame_valid, cloud.sign_known);
  store(patches.patch, patches.rank, patches.patches, patches.refused_normal);
  store(surface.borders, surface.strays, surface.loops, surface.stars, surface.refused, surface.refused_overlap,
        surface.components, surface.sides_by_volume, surface.kept_used, surface.kept_in_strays);
  store(made.reduction.report, made.swaps);
}

constexpr PartTask kMesh{PartStage::Mesh, 0};

struct Verdict {
  verify::PieceVerdict piece;
  std::uint64_t in_strays = 0;     // its points that belong to dropped pieces of the mesh
  std::vector<BlockTrace> traces;  // of its blocks, at least
};

/// What stands before the traces in the text of a verdict.
struct VerdictHead {
  std::uint64_t in_strays = 0, traces = 0;
};

Result<Verdict> read_verdict(const PartFile& file) {
  const std::string& text = file.text();
  const Error cut_short = fail(Code::IoFailed, "ends inside its text; remove it and run again");
  VerdictHead head;
  if (text.size() < sizeof head) return cut_short;
  std::memcpy(&head, text.data(), sizeof head);
  const std::size_t left = text.size() - sizeof head;
  if (head.traces > left / sizeof(BlockTrace)) return cut_short;
  Verdict verdict;
  verdict.in_strays = head.in_strays;
  verdict.traces.resize(static_cast<std::size_t>(head.traces));
  const std::size_t bytes = verdict.traces.size() * sizeof(BlockTrace);
  std::memcpy(verdict.traces.data(), text.data() + sizeof head, bytes);
  verdict.piece.seen = text.substr(sizeof head + bytes);
  verdict.piece.vertices.resize(static_cast<std::size_t>(file.rows()));
  TRY(file.read_rows(0, std::span(verdict.piece.vertices)));
  return verdict;
}

Result<void> make_verdict(const Cut& cut, const PartTask& task, const MadeSurface& made, const TracedPoints& all,
                          const What& what, const Context& context) {
  const PiecePoints piece(all.points, task.number, cut.pieces);
  VerdictHead head;
  TRY_ASSIGN(const verify::PieceVerdict verdict,
             judge_piece(made.surface, made.reduction.cloud, piece, what, context, head.in_strays));
  const std::vector<BlockTrace> traces = all.files.traces();
  head.traces = traces.size();
  const std::string name = name_of(task);
  TRY_ASSIGN(PartWriter writer,
             PartWriter::create(path_of(cut, name), kind_of(cut, name, sizeof(verify::PieceVerdict::Vertex))));
  TRY(writer.add_rows(std::span<const verify::PieceVerdict::Vertex>(verdict.vertices)));
  std::string text(reinterpret_cast<const char*>(&head), sizeof head);
  text.append(reinterpret_cast<const char*>(traces.data()), traces.size() * sizeof(BlockTrace));
  return writer.commit(text + verdict.seen);
}

}  // namespace

Result<void> keep_surface(const Cut& cut, const MadeSurface& made) {
  const std::string name = name_of(kMesh);
  TRY_ASSIGN(PartWriter writer, PartWriter::create(path_of(cut, name), kind_of(cut, name, 1)));
  Keeper keeper(writer);
  store_judged(keeper, made);
  store_rest(keeper, made);
  TRY(std::move(keeper.state));
  return writer.commit();
}

Result<std::optional<MadeSurface>> kept_surface(const Cut& cut) {
  const auto file = open_part(cut, kMesh);
  if (!file) return std::optional<MadeSurface>();
  MadeSurface made;
  Taker taker(*file);
  store_judged(taker, made);
  store_rest(taker, made);
  TRY(std::move(taker.state));
  made.reduction.cloud.index = BinIndex::over(made.reduction.cloud.bins);
  return std::optional<MadeSurface>(std::move(made));
}

Result<void> verify_piece(const Cut& cut, std::uint32_t piece, const TracedPoints& all, const What& what,
                          const Context& context) {
  const PartTask task{PartStage::Verify, piece};
  if (is_done(cut, task)) return {};
  TRY_ASSIGN(const PartFile file, need_part(cut, kMesh));
  MadeSurface made;
  Taker taker(file);
  store_judged(taker, made);
  TRY(std::move(taker.state));
  made.reduction.cloud.index = BinIndex::over(made.reduction.cloud.bins);
  return make_verdict(cut, task, made, all, what, context);
}

Result<Fit> measure_fit_in_pieces(const Cut& cut, const MadeSurface& made, const TracedPoints& all, const What& what,
                                  const Context& context) {
  for (std::uint32_t n = 0; n < cut.pieces; ++n) {
    const PartTask task{PartStage::Verify, n};
    if (!is_done(cut, task)) TRY(make_verdict(cut, task, made, all, what, context));
  }
  FitOfPieces fit(made.surface, made.reduction.cloud, what);
  for (std::uint32_t n = 0; n < cut.pieces; ++n) {
    TRY_ASSIGN(const PartFile file, need_part(cut, {PartStage::Verify, n}));
    TRY_ASSIGN(const Verdict verdict, read_verdict(file));
    TRY(fit.add(verdict.piece, verdict.in_strays));
    if (!all.files.recall(verdict.traces)) return fail(Code::IoFailed, "tells of blocks that the scan does not have");
  }
  return std::move(fit).fit();
}

}  // namespace scanmill::pipeline
