// SPDX-License-Identifier: Apache-2.0
// From pieces of the input to the frames and winners of all bins; cut_points.cpp has what follows.
#include "pipeline/cut_reduction.hpp"

#include <algorithm>
#include <cstring>
#include <queue>

#include "cloud/piece.hpp"
#include "pipeline/frame_rows.hpp"
#include "pipeline/read_order.hpp"

namespace scanmill::pipeline {
namespace {

using reduce::BinTotals;
using reduce::Frames;
using reduce::LocalFrame;
using reduce::Winner;

/// Bricks stay whole; every batch gets about as many bins as the others, in the order of keys.
void share_out(std::vector<Cell>& cells, std::uint64_t bins, const Cut& cut) {
  std::uint32_t batch = 0;
  std::uint64_t before = 0;
  for (std::size_t n = 0; n < cells.size(); ++n) {
    const bool begins = n == 0 || low_of(cells[n].low, cut.brick_bins) != low_of(cells[n - 1].low, cut.brick_bins);
    while (begins && batch + 1 < cut.batches && before * cut.batches >= bins * (batch + 1)) ++batch;
    cells[n].batch = batch;
    before += cells[n].rows;
  }
}

}  // namespace

Result<PartFile> need_link(const Cut& cut, std::uint32_t piece) {
  const std::string name = link_name(piece), path = path_of(cut, name);
  if (auto file = PartFile::open(path, kind_of(cut, name, sizeof(std::uint64_t)))) return *std::move(file);
  return fail(Code::IoFailed, "is not there or another run's; the task 'gather' makes it", path);
}

CutReduction::CutReduction(const PointSource& points, const reduce::LatticeParams& lattice,
                           const reduce::Params& params, Cut cut)
    : points_(points), lattice_(lattice), params_(params), cut_(std::move(cut)) {}

Result<void> CutReduction::make(const PartTask& task, const Context& context) const {
  if (is_done(cut_, task)) return {};
  switch (task.stage) {
    case PartStage::Map:
      return map(task.number, context);
    case PartStage::Gather:
      return gather(context);
    case PartStage::Frame:
      return frame(task.number, context);
    case PartStage::Pick:
      return pick(task.number, context);
    case PartStage::Points:
      return points(context);
    case PartStage::Thin:
      return thin(task.number, context);
    case PartStage::Settle:
      return settle(context);
    default:
      break;
  }
  return fail(Code::Internal, "is no part of the reduction", name_of(task));
}

Result<void> CutReduction::map(std::uint32_t piece, const Context& context) const {
  TRY_ASSIGN(const LocalFrame frame, reduce::frame_of_parts(points_, lattice_, params_));
  reduce::ReadCounts counts;
  const PiecePoints in_file(points_, piece, cut_.pieces);
  NoProgress quiet;
  TRY_ASSIGN(const auto gathered, gathered_if_scattered(in_file, lattice_, params_, context, quiet));
  const PointSource& points = gathered ? *gathered : static_cast<const PointSource&>(in_file);
  TRY_ASSIGN(const BinTotals totals, reduce::bin_points(points, frame, counts, context));
  const std::string name = name_of({PartStage::Map, piece});
  TRY_ASSIGN(PartWriter writer, PartWriter::create(path_of(cut_, name), kind_of(cut_, name, sizeof(TotalRow))));
  std::vector<TotalRow> rows;
  for (std::size_t first = 0; first < totals.bins.size(); first += rows.size()) {
    rows.resize(std::min(kRowsAtOnce, totals.bins.size() - first));
    for (std::size_t n = 0; n < rows.size(); ++n)
      rows[n] = total_row(totals.bins[first + n], totals.cells[first + n], totals.cells.direction(first + n));
    TRY(writer.add_rows(std::span<const TotalRow>(rows)));
  }
  const CountsText text = counts_text(counts);
  return writer.commit({reinterpret_cast<const char*>(&text), sizeof text});
}

Result<void> CutReduction::gather(const Context& context) const {
  TRY_ASSIGN(const LocalFrame frame, reduce::frame_of_parts(points_, lattice_, params_));
  std::vector<PartFile> files;
  std::vector<PartWriter> links;
  reduce::ReadCounts counts;
  for (std::uint32_t piece = 0; piece < cut_.pieces; ++piece) {
    TRY_ASSIGN(PartFile file, need_part(cut_, {PartStage::Map, piece}));
    CountsText text;
    if (file.text().size() != sizeof text)
      return fail(Code::IoFailed, "holds no counts", path_of(cut_, name_of({PartStage::Map, piece})));
    std::memcpy(&text, file.text().data(), sizeof text);
    add_counts(counts, text);
    files.push_back(std::move(file));
    const std::string name = link_name(piece);
    TRY_ASSIGN(PartWriter link, PartWriter::create(path_of(cut_, name), kind_of(cut_, name, sizeof(std::uint64_t))));
    links.push_back(std::move(link));
  }
  if (counts.points_used == 0) return fail(Code::BadInput, "no finite point in any file of the scan; nothing to mesh");
  std::vector<RowStream<TotalRow>> streams(files.begin(), files.end());
  const auto later = [&](std::size_t a, std::size_t b) {  // rows at hand were read when the piece was pushed
    const LocalBin x = (*streams[a].get())->local(), y = (*streams[b].get())->local();
    return x == y ? a > b : stands_before(frame.base, y, x);
  };
  std::priority_queue<std::size_t, std::vector<std::size_t>, decltype(later)> next(later);
  for (std::size_t n = 0; n < streams.size(); ++n) {
    if (streams[n].at_end()) continue;
    TRY(streams[n].get());
    next.push(n);
  }
  const std::string name = name_of({PartStage::Gather, 0});
  TRY_ASSIGN(PartWriter writer, PartWriter::create(path_of(cut_, name), kind_of(cut_, name, sizeof(TotalRow))));
  std::vector<LocalBin> bins;
  reduce::BinCells sums;
  std::vector<Cell> cells;
  const std::uint32_t cell_bins = std::min(cut_.brick_bins, 32u);
  while (!next.empty()) {
    if (context.cancel.is_set()) return fail(Code::Cancelled, "stopped on request");
    TotalRow row = **streams[next.top()].get();
    const std::uint64_t at = bins.size();
    for (bool first = true; !next.empty(); first = false) {
      const std::size_t n = next.top();
      const TotalRow& other = **streams[n].get();
      if (other.local() != row.local()) break;
      if (!first) add_row(row, other);
      TRY(links[n].add_rows(std::span<const std::uint64_t>(&at, 1)));
      next.pop();
      streams[n].step();
      if (streams[n].at_end()) continue;
      TRY(streams[n].get());
      next.push(n);
    }
    const LocalBin low = low_of(row.local(), cell_bins);
    if (cells.empty() || cells.back().low != low) cells.push_back({low, 0, at, 0});
    ++cells.back().rows;
    bins.push_back(row.local());
    push_row(sums, row);
    TRY(writer.add_rows(std::span<const TotalRow>(&row, 1)));
  }
  TRY(reduce::check_numbers(bins.size(), 0, frame.lattice.edge_mm));
  share_out(cells, bins.size(), cut_);
  const reduce::Levels levels = reduce::levels_of_parts(frame, std::move(bins), sums, context);
  if (context.cancel.is_set()) return fail(Code::Cancelled, "stopped on request");
  for (PartWriter& link : links) TRY(link.commit());
  TotalsText text;
  text.counts = counts_text(counts);
  text.noise = levels.noise;
  text.frame_radius = levels.frame_radius;
  text.cell_bins = cell_bins;
  text.cells = cells.size();
  std::string bytes(reinterpret_cast<const char*>(&text), sizeof text);
  bytes.append(reinterpret_cast<const char*>(cells.data()), cells.size() * sizeof(Cell));
  return writer.commit(bytes);
}

Result<void> CutReduction::frame(std::uint32_t batch, const Context& context) const {
  TRY_ASSIGN(const LocalFrame frame, reduce::frame_of_parts(points_, lattice_, params_));
  TRY_ASSIGN(const Totals totals, need_totals(cut_));
  const std::string name = name_of({PartStage::Frame, batch});
  TRY_ASSIGN(PartWriter writer, PartWriter::create(path_of(cut_, name), kind_of(cut_, name, sizeof(FrameRow))));
  for (const Brick& brick : bricks_of(totals, cut_.brick_bins)) {
    if (brick.batch != batch) continue;
    const auto runs = runs_around(totals, frame.base, brick, cut_.brick_bins, reduce::kFrameHalo);
    TRY_ASSIGN(const std::vector<TotalRow> around, read_runs<TotalRow>(totals.file, runs));
    std::vector<LocalBin> bins;
    reduce::BinCells sums;
    for (const TotalRow& row : around) {
      if (!is_inside(row.local(), brick.low, cut_.brick_bins, reduce::kFrameHalo)) continue;
      bins.push_back(row.local());
      push_row(sums, row);
    }
    const Frames frames = reduce::frames_of_parts(frame, bins, sums, totals.text.frame_radius, context);
    if (context.cancel.is_set()) return fail(Code::Cancelled, "stopped on request");
    std::vector<FrameRow> rows;
    for (std::size_t n = 0; n < bins.size(); ++n)
      if (is_inside(bins[n], brick.low, cut_.brick_bins, 0)) rows.push_back(frame_row(frames, n));
    TRY(writer.add_rows(std::span<const FrameRow>(rows)));
  }
  return writer.commit();
}

namespace {

/// All frames, or those at `rows` (ascending).
Result<Frames> read_frames(FrameReader& reader, std::uint64_t count, const std::vector<std::uint64_t>* rows) {
  Frames frames;
  frames.resize(static_cast<std::size_t>(count));
  for (std::size_t n = 0; n < count; ++n) {
    TRY_ASSIGN(const FrameRow* row, reader.get(rows ? (*rows)[n] : n));
    set_frame(frames, n, *row);
  }
  return frames;
}

}  // namespace

Result<void> CutReduction::pick(std::uint32_t piece, const Context& context) const {
  TRY_ASSIGN(const LocalFrame frame, reduce::frame_of_parts(points_, lattice_, params_));
  TRY_ASSIGN(const Totals totals, need_totals(cut_));
  TRY_ASSIGN(const PartFile map, need_part(cut_, {PartStage::Map, piece}));
  TRY_ASSIGN(const PartFile link, need_link(cut_, piece));
  TRY_ASSIGN(FrameReader reader, FrameReader::open(cut_, totals));
  const std::string name = name_of({PartStage::Pick, piece});
  TRY_ASSIGN(PartWriter writer, PartWriter::create(path_of(cut_, name), kind_of(cut_, name, sizeof(PickRow))));
  double median = 0;
  if (params_.edge_aware) {
    TRY_ASSIGN(const Frames all, read_frames(reader, totals.file.rows(), nullptr));
    median = reduce::median_residual_of(all);
  }
  std::vector<LocalBin> bins;
  bins.reserve(static_cast<std::size_t>(map.rows()));
  for (RowStream<TotalRow> rows(map); !rows.at_end(); rows.step()) {
    TRY_ASSIGN(const TotalRow* row, rows.get());
    bins.push_back(row->local());
  }
  std::vector<std::uint64_t> at(static_cast<std::size_t>(link.rows()));
  TRY(link.read_rows(0, std::span<std::uint64_t>(at)));
  if (at.size() != bins.size())
    return fail(Code::IoFailed, "holds other bins than the piece", path_of(cut_, link_name(piece)));
  TRY_ASSIGN(const Frames frames, read_frames(reader, at.size(), &at));
  const auto targets = reduce::targets_of(frame, bins, frames, median, params_);
  const BinIndex index = BinIndex::over(bins);
  const PiecePoints in_file(points_, piece, cut_.pieces);
  NoProgress quiet;
  TRY_ASSIGN(const auto gathered, gathered_if_scattered(in_file, lattice_, params_, context, quiet));
  const PointSource& points = gathered ? *gathered : static_cast<const PointSource&>(in_file);
  TRY_ASSIGN(const std::vector<Winner> winners, reduce::pick_against(points, frame, index, targets, context));
  std::vector<PickRow> rows;
  for (std::size_t first = 0; first < winners.size(); first += rows.size()) {
    rows.resize(std::min(kRowsAtOnce, winners.size() - first));
    for (std::size_t n = 0; n < rows.size(); ++n) rows[n] = pick_row(winners[first + n]);
    TRY(writer.add_rows(std::span<const PickRow>(rows)));
  }
  return writer.commit();
}

Result<BrickCounts> CutReduction::bricks() const {
  TRY_ASSIGN(const Totals totals, need_totals(cut_));
  BrickCounts counts;
  for (const Brick& brick : bricks_of(totals, cut_.brick_bins)) {
    ++counts.bricks;
    counts.bins += brick.rows;
    counts.most_bins = std::max(counts.most_bins, brick.rows);
  }
  return counts;
}

}  // namespace scanmill::pipeline
