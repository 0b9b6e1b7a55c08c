// SPDX-License-Identifier: Apache-2.0
// Rows of the parts of a cut reduction, without padding, and back.
#pragma once
#include <cstdint>

#include "reduce/parts.hpp"

namespace scanmill::pipeline {

struct TotalRow {
  std::int32_t bin[3];
  std::uint32_t view;
  double score, place[3];
  std::uint64_t row;
  std::int64_t moments[13];  // count, sums, products, view direction
  LocalBin local() const { return {bin[0], bin[1], bin[2]}; }
};
struct FrameRow {
  double centroid[3], normal[3];
  float residual, variation, plane_distance;
  std::uint8_t valid, sign_known, none[2];
};
struct PickRow {
  double score, place[3];
  std::uint64_t row;
  std::uint32_t view, none;
};
/// A bin's point with its frame. `drop`: by the rules that look at no other point.
struct PointRow {
  double measured[3], projected[3], normal[3];
  std::uint64_t row;
  std::int64_t count;
  std::int32_t bin[3];
  std::uint32_t view;
  float residual, variation, plane_distance;
  std::uint8_t drop, valid, sign_known, none;
  LocalBin local() const { return {bin[0], bin[1], bin[2]}; }
};
struct ThinRow {
  reduce::Drop drop;
  std::uint8_t open;
};
static_assert(sizeof(TotalRow) == 160 && sizeof(FrameRow) == 64 && sizeof(PickRow) == 48 && sizeof(PointRow) == 120);

struct CountsText {
  std::uint64_t points_read = 0, not_finite = 0, sensor_invalid = 0, points_used = 0;
  double low[3] = {}, high[3] = {};
};

inline TotalRow total_row(const LocalBin& bin, const reduce::Cell& cell, const reduce::Direction& direction) {
  const reduce::WholeSums& m = cell.sums;
  auto whole = [](double sum) { return static_cast<std::int64_t>(sum); };
  return {{bin[0], bin[1], bin[2]},
          index_of(cell.view),
          cell.score,
          {cell.position.x, cell.position.y, cell.position.z},
          cell.row,
          {whole(m.count), whole(m.x), whole(m.y), whole(m.z), whole(m.xx), whole(m.xy), whole(m.xz), whole(m.yy),
           whole(m.yz), whole(m.zz), direction[0], direction[1], direction[2]}};
}
template <class Row>
reduce::Winner winner_of(const Row& row) {
  return {row.score, {row.place[0], row.place[1], row.place[2]}, {ViewId{row.view}, row.row}};
}
inline void push_row(reduce::BinCells& cells, const TotalRow& row) {
  auto sum = [&](std::size_t k) { return static_cast<double>(row.moments[k]); };
  reduce::Cell cell;
  cell.keep_better(winner_of(row));
  cell.sums = {.xx = sum(4),
               .yy = sum(7),
               .zz = sum(9),
               .count = sum(0),
               .xy = sum(5),
               .yz = sum(8),
               .xz = sum(6),
               .z = sum(3),
               .x = sum(1),
               .y = sum(2)};
  cells.push_back(cell, {row.moments[10], row.moments[11], row.moments[12]});
}
/// The sums of both, and the better winner.
inline void add_row(TotalRow& into, const TotalRow& other) {
  if (reduce::better(winner_of(other), winner_of(into))) {
    into.view = other.view;
    into.score = other.score;
    for (int k = 0; k < 3; ++k) into.place[k] = other.place[k];
    into.row = other.row;
  }
  for (int k = 0; k < 13; ++k) into.moments[k] += other.moments[k];
}

inline PickRow pick_row(const reduce::Winner& w) {
  return {w.score, {w.position.x, w.position.y, w.position.z}, w.source.row, index_of(w.source.view), 0};
}

inline FrameRow frame_row(const reduce::Frames& f, std::size_t n) {
  const Vec3 c = f.centroid[n], v = f.normal[n];
  return {{c.x, c.y, c.z},     {v.x, v.y, v.z}, f.residual[n],   f.variation[n],
          f.plane_distance[n], f.valid[n],      f.sign_known[n], {}};
}
inline void set_frame(reduce::Frames& f, std::size_t n, const FrameRow& row) {
  f.centroid[n] = {row.centroid[0], row.centroid[1], row.centroid[2]};
  f.normal[n] = {row.normal[0], row.normal[1], row.normal[2]};
  f.residual[n] = row.residual;
  f.variation[n] = row.variation;
  f.plane_distance[n] = row.plane_distance;
  f.valid[n] = row.valid;
  f.sign_known[n] = row.sign_known;
}

inline PointRow point_row(const reduce::ReducedCloud& c, std::size_t n) {
  const Vec3 m = c.measured[n], p = c.projected[n], v = c.normal[n];
  const LocalBin& bin = c.bins[n];
  return {{m.x, m.y, m.z},
          {p.x, p.y, p.z},
          {v.x, v.y, v.z},
          c.source[n].row,
          c.counts[n],
          {bin[0], bin[1], bin[2]},
          index_of(c.source[n].view),
          c.residual[n],
          c.variation[n],
          c.plane_distance[n],
          static_cast<std::uint8_t>(c.drop[n]),
          c.frame_valid[n],
          c.sign_known[n],
          0};
}
/// Behind the rows there are.
inline void push_point(reduce::ReducedCloud& c, const PointRow& row) {
  c.bins.push_back(row.local());
  c.measured.push_back({row.measured[0], row.measured[1], row.measured[2]});
  c.source.push_back({ViewId{row.view}, row.row});
  c.counts.push_back(row.count);
  c.drop.push_back(static_cast<reduce::Drop>(row.drop));
  c.projected.push_back({row.projected[0], row.projected[1], row.projected[2]});
  c.normal.push_back({row.normal[0], row.normal[1], row.normal[2]});
  c.residual.push_back(row.residual);
  c.variation.push_back(row.variation);
  c.plane_distance.push_back(row.plane_distance);
  c.frame_valid.push_back(row.valid);
  c.sign_known.push_back(row.sign_known);
}
inline void reserve_points(reduce::ReducedCloud& c, std::size_t count) {
  c.bins.reserve(count);
  c.measured.reserve(count);
  c.source.reserve(count);
  c.counts.reserve(count);
  c.drop.reserve(count);
  c.projected.reserve(count);
  c.normal.reserve(count);
  c.residual.reserve(count);
  c.variation.reserve(count);
  c.plane_distance.reserve(count);
  c.frame_valid.reserve(count);
  c.sign_known.reserve(count);
}

inline CountsText counts_text(const reduce::ReadCounts& c) {
  CountsText text{c.points_read, c.not_finite, c.sensor_invalid, c.points_used, {}, {}};
  if (c.points_used == 0) return text;
  const Vec3 low = c.bounds.low, high = c.bounds.high;
  text.low[0] = low.x, text.low[1] = low.y, text.low[2] = low.z;
  text.high[0] = high.x, text.high[1] = high.y, text.high[2] = high.z;
  return text;
}
inline void add_counts(reduce::ReadCounts& counts, const CountsText& text) {
  counts.points_read += text.points_read;
  counts.not_finite += text.not_finite;
  counts.sensor_invalid += text.sensor_invalid;
  counts.points_used += text.points_used;
  if (text.points_used == 0) return;
  counts.bounds.add(Vec3{text.low[0], text.low[1], text.low[2]});
  counts.bounds.add(Vec3{text.high[0], text.high[1], text.high[2]});
}

}  // namespace scanmill::pipeline
