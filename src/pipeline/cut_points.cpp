// SPDX-License-Identifier: Apache-2.0
// From winners and frames to the reduced cloud: joined row by row, thinned brick by brick.
#include <algorithm>
#include <cstring>

#include "pipeline/cut_reduction.hpp"
#include "pipeline/frame_rows.hpp"
#include "pipeline/point_parts.hpp"

namespace scanmill::pipeline {
namespace {

using reduce::BinTotals;
using reduce::Drop;
using reduce::Frames;
using reduce::LocalFrame;
using reduce::ReducedCloud;

constexpr PartTask kPoints{PartStage::Points, 0}, kSettle{PartStage::Settle, 0};
/// Bins around a brick whose points are looked at when it is thinned. Whether a point stays hangs on better ones near
/// it, whether these stay on theirs: a chain that rarely goes on for more than a few points, but on exact planes, where
/// all are equally good, it does not end.
constexpr std::int32_t kThinHalo = 12;

/// All rows; `drop` as the points have it.
Result<ReducedCloud> all_points(const PointParts& points) {
  ReducedCloud cloud = empty_cloud(points.text);
  reserve_points(cloud, static_cast<std::size_t>(points.file.rows()));
  for (RowStream<PointRow> rows(points.file); !rows.at_end(); rows.step()) {
    TRY_ASSIGN(const PointRow* row, rows.get());
    push_point(cloud, *row);
  }
  cloud.index = BinIndex::over(cloud.bins);
  return cloud;
}

/// The winners of the second pass, piece by piece, as the rows of all bins come by.
class PickStreams {
 public:
  static Result<PickStreams> open(const Cut& cut) {
    PickStreams streams;
    for (std::uint32_t piece = 0; piece < cut.pieces; ++piece) {
      TRY_ASSIGN(PartFile picks, need_part(cut, {PartStage::Pick, piece}));
      TRY_ASSIGN(PartFile link, need_link(cut, piece));
      if (picks.rows() != link.rows())
        return fail(Code::IoFailed, "holds other bins than the piece", path_of(cut, link_name(piece)));
      streams.files_.push_back(std::move(picks));
      streams.files_.push_back(std::move(link));
    }
    for (std::size_t n = 0; n < streams.files_.size(); n += 2)
      streams.pieces_.push_back(
          {RowStream<PickRow>(streams.files_[n]), RowStream<std::uint64_t>(streams.files_[n + 1])});
    return streams;
  }
  /// Into the cells of rows [first, first + cells.size()); `first` does not fall.
  Result<void> take(std::uint64_t first, reduce::BinCells& cells) {
    for (Piece& piece : pieces_)
      for (; !piece.links.at_end(); piece.picks.step(), piece.links.step()) {
        TRY_ASSIGN(const std::uint64_t* at, piece.links.get());
        if (*at >= first + cells.size()) break;
        TRY_ASSIGN(const PickRow* pick, piece.picks.get());
        cells[static_cast<std::size_t>(*at - first)].keep_better(winner_of(*pick));
      }
    return {};
  }

 private:
  struct Piece {
    RowStream<PickRow> picks;
    RowStream<std::uint64_t> links;
  };
  std::vector<PartFile> files_;
  std::vector<Piece> pieces_;
};

}  // namespace

Result<PointParts> need_points(const Cut& cut) {
  TRY_ASSIGN(PartFile file, need_part(cut, kPoints));
  PointParts points{std::move(file), {}};
  if (points.file.text().size() != sizeof points.text)
    return fail(Code::IoFailed, "ends inside its text; remove it and run again", path_of(cut, name_of(kPoints)));
  std::memcpy(&points.text, points.file.text().data(), sizeof points.text);
  return points;
}

ReducedCloud empty_cloud(const PointsText& text) {
  ReducedCloud cloud;
  cloud.lattice = {text.edge_mm, {text.origin[0], text.origin[1], text.origin[2]}};
  cloud.base = {text.base[0], text.base[1], text.base[2]};
  return cloud;
}

Result<void> CutReduction::points(const Context& context) const {
  TRY_ASSIGN(const LocalFrame frame, reduce::frame_of_parts(points_, lattice_, params_));
  TRY_ASSIGN(const Totals totals, need_totals(cut_));
  TRY_ASSIGN(FrameReader reader, FrameReader::open(cut_, totals));
  const bool is_picked = params_.representative == reduce::Representative::Surface;
  std::optional<PickStreams> picks;
  if (is_picked) {
    TRY_ASSIGN(picks, PickStreams::open(cut_));
  }
  TRY_ASSIGN(PartWriter writer, create_part(cut_, kPoints));
  Frames residuals;  // of all rows; the rest of them stays empty
  std::vector<PointRow> rows;
  RowStream<TotalRow> total(totals.file);
  while (!total.at_end()) {
    if (context.cancel.is_set()) return fail(Code::Cancelled, "stopped on request");
    const std::uint64_t first = total.row();
    const auto count = static_cast<std::size_t>(std::min<std::uint64_t>(kRowsAtOnce, totals.file.rows() - first));
    BinTotals some;
    Frames frames;
    frames.resize(count);
    for (std::size_t n = 0; n < count; ++n, total.step()) {
      TRY_ASSIGN(const TotalRow* row, total.get());
      reduce::Cell cell;
      cell.sums.count = static_cast<double>(row->moments[0]);
      if (!is_picked) cell.keep_better(winner_of(*row));
      some.bins.push_back(row->local());
      some.cells.push_back(cell, {});
      TRY_ASSIGN(const FrameRow* of, reader.get(first + n));
      set_frame(frames, n, *of);
    }
    residuals.residual.insert(residuals.residual.end(), frames.residual.begin(), frames.residual.end());
    residuals.valid.insert(residuals.valid.end(), frames.valid.begin(), frames.valid.end());
    if (picks) TRY(picks->take(first, some.cells));
    const ReducedCloud part = reduce::points_of_parts(frame, std::move(some), std::move(frames), params_, context);
    rows.clear();
    for (std::size_t n = 0; n < count; ++n) rows.push_back(point_row(part, n));
    TRY(writer.add_rows(std::span<const PointRow>(rows)));
  }
  const Vec3 origin = frame.lattice.origin;
  const PointsText text{frame.lattice.edge_mm,
                        {origin.x, origin.y, origin.z},
                        {frame.base.i, frame.base.j, frame.base.k},
                        reduce::median_residual_of(residuals)};
  return writer.commit({reinterpret_cast<const char*>(&text), sizeof text});
}

Result<void> CutReduction::thin(std::uint32_t batch, const Context& context) const {
  TRY_ASSIGN(const Totals totals, need_totals(cut_));
  TRY_ASSIGN(const PointParts points, need_points(cut_));
  TRY_ASSIGN(PartWriter writer, create_part(cut_, {PartStage::Thin, batch}));
  const ReducedCloud none = empty_cloud(points.text);
  for (const Brick& brick : bricks_of(totals, cut_.brick_bins)) {
    if (brick.batch != batch) continue;
    const auto runs = runs_around(totals, none.base, brick, cut_.brick_bins, kThinHalo);
    TRY_ASSIGN(const std::vector<PointRow> around, read_runs<PointRow>(points.file, runs));
    ReducedCloud part = empty_cloud(points.text);
    std::vector<std::uint8_t> seen;
    for (const PointRow& row : around) {
      if (!is_inside(row.local(), brick.low, cut_.brick_bins, kThinHalo)) continue;
      push_point(part, row);
      seen.push_back(is_inside(row.local(), brick.low, cut_.brick_bins, kThinHalo - reduce::kThinReach));
    }
    part.index = BinIndex::over(part.bins);
    const auto open = reduce::thin_part(part, seen, params_, context);
    if (context.cancel.is_set()) return fail(Code::Cancelled, "stopped on request");
    std::vector<ThinRow> rows;
    for (std::size_t n = 0; n < part.size(); ++n)
      if (is_inside(part.bins[n], brick.low, cut_.brick_bins, 0)) rows.push_back({part.drop[n], open[n]});
    TRY(writer.add_rows(std::span<const ThinRow>(rows)));
  }
  return writer.commit();
}

Result<void> CutReduction::settle(const Context& context) const {
  TRY_ASSIGN(const PointParts points, need_points(cut_));
  std::vector<Drop> drops;
  drops.reserve(static_cast<std::size_t>(points.file.rows()));
  bool is_open = false;
  for (std::uint32_t batch = 0; batch < cut_.batches; ++batch) {
    TRY_ASSIGN(const PartFile file, need_part(cut_, {PartStage::Thin, batch}));
    for (RowStream<ThinRow> rows(file); !rows.at_end(); rows.step()) {
      TRY_ASSIGN(const ThinRow* row, rows.get());
      drops.push_back(row->drop);
      is_open |= row->open != 0;
    }
  }
  if (drops.size() != points.file.rows())
    return fail(Code::IoFailed, "holds other bins than were thinned; remove the folder and run again",
                path_of(cut_, name_of(kPoints)));
  if (is_open) {
    TRY_ASSIGN(ReducedCloud cloud, all_points(points));
    reduce::thin_part(cloud, {}, params_, context);
    drops = std::move(cloud.drop);
  }
  if (context.cancel.is_set()) return fail(Code::Cancelled, "stopped on request");
  TRY_ASSIGN(PartWriter writer, create_part(cut_, kSettle));
  TRY(writer.add_rows(std::span<const Drop>(drops)));
  return writer.commit();
}

Result<reduce::Reduction> join_reduction(const Cut& cut) {
  TRY_ASSIGN(const Totals totals, need_totals(cut));
  TRY_ASSIGN(const PointParts points, need_points(cut));
  TRY_ASSIGN(const PartFile settled, need_part(cut, kSettle));
  TRY_ASSIGN(ReducedCloud cloud, all_points(points));
  if (settled.rows() != cloud.size())
    return fail(Code::IoFailed, "holds other bins than the points; remove the folder and run again",
                path_of(cut, name_of(kSettle)));
  TRY(settled.read_rows(0, std::span(cloud.drop)));
  reduce::ReadCounts counts;
  add_counts(counts, totals.text.counts);
  return reduce::join_parts(std::move(cloud), counts, {totals.text.noise, totals.text.frame_radius},
                            points.text.median_residual);
}

Result<ReducedCloud> join_bins(const Cut& cut) {
  TRY_ASSIGN(const PointParts points, need_points(cut));
  ReducedCloud cloud = empty_cloud(points.text);
  cloud.bins.reserve(static_cast<std::size_t>(points.file.rows()));
  for (RowStream<PointRow> rows(points.file); !rows.at_end(); rows.step()) {
    TRY_ASSIGN(const PointRow* row, rows.get());
    cloud.bins.push_back(row->local());
  }
  cloud.index = BinIndex::over(cloud.bins);
  return cloud;
}

}  // namespace scanmill::pipeline
