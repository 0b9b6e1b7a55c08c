// SPDX-License-Identifier: Apache-2.0
// Which bins of the part each view sees, at what angle, and how views overlap.
#pragma once
#include <cstdint>
#include <vector>

#include "base/context.hpp"
#include "base/progress.hpp"
#include "pipeline/scan_points.hpp"
#include "reduce/reduce.hpp"

namespace scanmill::pipeline {

struct ViewCoverage {
  std::uint64_t bins = 0, only_here = 0;
  double median_angle_deg = 0;        // between the surface's normal and the way to the sensor, over its bins
  double best_overlap = 0;            // greatest share of its bins that one other view sees too
  std::size_t best_neighbour = 0;     // that view
  std::vector<std::uint64_t> shared;  // bins shared with every view; empty above 400 views
};

struct Coverage {
  double bin_mm = 0;
  std::uint64_t bins = 0;
  std::vector<std::uint64_t> seen_by;  // [n]: bins seen by n + 1 views; the last entry: by so many or more
  double median_best_angle_deg = 0;    // per bin the least angle of the views that see it
  std::uint64_t bins_within_60_deg = 0, bins_with_angle = 0;
  std::vector<ViewCoverage> views;  // one per view of points.views()
};

/// One pass over all points; `cloud` holds their bins. Sums over bins in key order, so the same for any threads.
/// cost  reading, one look-up per point, and 4 bytes per (block, bin)
Result<Coverage> coverage_of(const ScanPoints& points, const reduce::ReducedCloud& cloud, const Context& context,
                             Progress& progress);

}  // namespace scanmill::pipeline
