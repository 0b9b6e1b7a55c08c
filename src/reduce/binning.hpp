// SPDX-License-Identifier: Apache-2.0
// Passes over the points: winners and moments per bin, and winners against a plane. Internal to `reduce`, and to
// reductions in parts (parts.hpp).
#pragma once
#include <vector>

#include "reduce/cells.hpp"
#include "reduce/reduce.hpp"

namespace scanmill::reduce {

/// Corner of the local bins: a multiple of 1024 near the cloud, so that bins fit 32 bits.
struct LocalFrame {
  Lattice lattice;
  BinKey base;
  /// False when the bin does not fit.
  bool bin_of(Vec3 p, LocalBin& bin) const;
};

/// One entry per occupied bin, ascending key.
struct BinTotals {
  std::vector<LocalBin> bins;
  BinCells cells;
  std::uint64_t index_bytes = 0, cell_bytes = 0;  // at their largest
};

struct ReadCounts {
  std::uint64_t points_read = 0, not_finite = 0, sensor_invalid = 0, points_used = 0;
  Bounds bounds;
};

/// Rows are numbered by 31 bits, corners of triangles (two a point, three each) by 32.
inline constexpr std::uint64_t kMostBins = (1ull << 31) - 1, kMostKept = 1ull << 29;
/// A bin edge that gives fewer bins of a surface is what helps.
/// errors  BadInput above kMostBins or kMostKept, with an edge that would do
Result<void> check_numbers(std::uint64_t bins, std::uint64_t kept, double edge_mm);

/// Bounds and counts alone.
Result<ReadCounts> read_bounds(const PointSource& points, const Context& context);
/// A first point, for the base of local bins. errors  BadInput when there is none
Result<Vec3> first_point(const PointSource& points);
/// Pass 1. Private trees and cells per worker, joined by bin: minimum and exact sums commute, so any split gives the
/// same.
Result<BinTotals> bin_points(const PointSource& points, const LocalFrame& frame, ReadCounts& counts,
                             const Context& context);
/// Number of occupied bins at a trial edge.
Result<std::uint64_t> count_bins(const PointSource& points, const LocalFrame& frame, const Context& context);

/// What pass 2 measures a point of a bin against.
struct Target {
  Vec3 foot;  // global, mm
  Vec3 normal;
  bool crease = false;  // keep the point farthest from the plane through `foot`
};
/// Pass 2: per row the point with the least |p-f|^2 + 3 ((p-f).n)^2, or at creases the farthest from the plane.
Result<std::vector<Winner>> pick_against(const PointSource& points, const LocalFrame& frame, const BinIndex& index,
                                         const std::vector<Target>& targets, const Context& context);

}  // namespace scanmill::reduce
