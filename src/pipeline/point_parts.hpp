// SPDX-License-Identifier: Apache-2.0
// The points of a cut scan, a row for every bin, ascending key.
#pragma once
#include "pipeline/cut_scan.hpp"
#include "pipeline/part_rows.hpp"

namespace scanmill::pipeline {

/// What stands behind the points.
struct PointsText {
  double edge_mm = 0, origin[3] = {};
  std::int64_t base[3] = {};
  double median_residual = 0;
};

struct PointParts {
  PartFile file;
  PointsText text;
};

/// errors  IoFailed naming the task that makes it
Result<PointParts> need_points(const Cut& cut);
/// Lattice and base alone.
reduce::ReducedCloud empty_cloud(const PointsText& text);

}  // namespace scanmill::pipeline
