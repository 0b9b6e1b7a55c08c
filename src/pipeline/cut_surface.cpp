// SPDX-License-Identifier: Apache-2.0
#include "pipeline/cut_surface.hpp"

#include <cstring>
#include <utility>

#include "cloud/piece.hpp"
#include "pipeline/cut_reduction.hpp"
#include "pipeline/cut_stars.hpp"
#include "pipeline/cut_swaps.hpp"
#include "pipeline/read_order.hpp"
#include "pipeline/surface_lists.hpp"

namespace scanmill::pipeline {
namespace {

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

Result<void> make_verdict(const Cut& cut, const PartTask& task, const MeshedSurface& surface,
                          const reduce::ReducedCloud& cloud, const TracedPoints& all, const What& what,
                          const Context& context) {
  const PiecePoints in_file(all.points, task.number, verify_tasks(cut));
  NoProgress quiet;
  TRY_ASSIGN(const auto gathered, gathered_if_scattered(in_file, what.lattice, what.reduce, context, quiet));
  const PointSource& piece = gathered ? *gathered : static_cast<const PointSource&>(in_file);
  VerdictHead head;
  TRY_ASSIGN(const verify::PieceVerdict verdict, judge_piece(surface, cloud, piece, what, context, head.in_strays));
  const std::vector<BlockTrace> traces = all.files.traces();
  head.traces = traces.size();
  TRY_ASSIGN(PartWriter writer, create_part(cut, task));
  TRY(writer.add_rows(std::span<const verify::PieceVerdict::Vertex>(verdict.vertices)));
  std::string text(reinterpret_cast<const char*>(&head), sizeof head);
  text.append(reinterpret_cast<const char*>(traces.data()), traces.size() * sizeof(BlockTrace));
  return writer.commit(text + verdict.seen);
}

}  // namespace

Result<void> mesh_cut(const Cut& cut, const What& what, const Context& context, Progress& progress) {
  if (is_done(cut, kMeshTask)) return {};
  TRY_ASSIGN(const reduce::Reduction reduction, join_reduction(cut));
  std::optional<std::vector<stars::Ballot>> ballots;
  if (what.grow.engine != Engine::Front) {
    TRY_ASSIGN(ballots, read_ballots(cut));
  }
  TRY_ASSIGN(const MeshedSurface surface,
             mesh_surface(reduction.cloud, reduction.report.bounds, what, context, progress, std::move(ballots)));
  return write_mesh(cut, surface, reduction.cloud.bins, reduction.report.bin_mm);
}

Result<MadeSurface> join_surface(const Cut& cut) {
  TRY_ASSIGN(const PartFile file, need_part(cut, kJoinTask));
  MadeSurface made;
  TRY_ASSIGN(made.reduction, join_reduction(cut));
  Taker taker(file);
  store_judged(taker, made.surface);
  store_rest(taker, made.surface);
  taker(made.swaps);
  TRY(std::move(taker.state));
  return made;
}

Result<void> verify_piece(const Cut& cut, std::uint32_t piece, const TracedPoints& all, const What& what,
                          const Context& context) {
  const PartTask task{PartStage::Verify, piece};
  if (is_done(cut, task)) return {};
  TRY_ASSIGN(const PartFile file, need_part(cut, kJoinTask));
  MeshedSurface surface;
  Taker taker(file);
  store_judged(taker, surface);
  TRY(std::move(taker.state));
  TRY_ASSIGN(const reduce::ReducedCloud bins, join_bins(cut));
  return make_verdict(cut, task, surface, bins, all, what, context);
}

Result<Fit> measure_fit_in_pieces(const Cut& cut, const MadeSurface& made, const TracedPoints& all, const What& what,
                                  const Context& context) {
  for (std::uint32_t n = 0; n < verify_tasks(cut); ++n) {
    const PartTask task{PartStage::Verify, n};
    if (!is_done(cut, task)) TRY(make_verdict(cut, task, made.surface, made.reduction.cloud, all, what, context));
  }
  FitOfPieces fit(made.surface, made.reduction.cloud, what);
  for (std::uint32_t n = 0; n < verify_tasks(cut); ++n) {
    TRY_ASSIGN(const PartFile file, need_part(cut, {PartStage::Verify, n}));
    TRY_ASSIGN(const Verdict verdict, read_verdict(file));
    TRY(fit.add(verdict.piece, verdict.in_strays));
    if (!all.files.recall(verdict.traces)) return fail(Code::IoFailed, "tells of blocks that the scan does not have");
  }
  return std::move(fit).fit();
}

}  // namespace scanmill::pipeline
