// SPDX-License-Identifier: Apache-2.0
// The job's `lattice` and `reduce` sections.
#pragma once
#include <cstdint>
#include <optional>
#include <span>

#include "base/fields.hpp"

namespace scanmill::reduce {

enum class Origin : std::int32_t { Absolute, Bounds };
enum class Representative : std::int32_t { Surface, Centre };
enum class NeighbourPositions : std::int32_t { Projected, Measured };

/// Exactly one of the first three is given.
struct LatticeParams {
  std::optional<double> bin_mm;         // h
  std::optional<double> target_points;  // bin edge chosen so that about this many points are kept
  std::optional<double> target_bins;    // the same by occupied bins
  Origin origin = Origin::Absolute;
  static std::span<const Field> fields();
};

/// Defaults are those of `profile: scan`.
struct Params {
  Representative representative = Representative::Surface;
  std::int64_t min_points_per_bin = 1;
  std::optional<double> max_centre_distance;           // c1, bin edges
  std::optional<double> min_neighbour_distance = 0.6;  // c2, bin edges
  NeighbourPositions neighbour_positions = NeighbourPositions::Projected;
  bool edge_aware = false;
  static std::span<const Field> fields();
  /// The rules of `profile: paper`: centre, c2 0.5 on measured positions.
  static Params paper();
};

}  // namespace scanmill::reduce
