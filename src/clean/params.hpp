// SPDX-License-Identifier: Apache-2.0
// The job's `clean` section (Bradley 2001, section 4: fixture and deck points are deleted; by rule here). All lengths
// in mm, all places in the global frame.
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/fields.hpp"
#include "geom/vec3.hpp"

namespace scanmill::clean {

/// Half-open: low <= p < high on each axis.
struct Box {
  Vec3 low, high;
  bool holds(Vec3 p) const {
    return p.x >= low.x && p.x < high.x && p.y >= low.y && p.y < high.y && p.z >= low.z && p.z < high.z;
  }
};

/// Points within `distance_mm` of a plane, and with `below` everything on its far side.
struct PlaneRule {
  bool fit = false;            // find the plane with most points instead of taking `point` and `normal`
  std::optional<Vec3> point;   // on the given plane
  std::optional<Vec3> normal;  // upwards, any length; with `fit` the direction the plane must face about
  double distance_mm = 0;      // must be given, > 0
  bool below = false;
  double min_share = 0.2;    // of the points: a fitted plane with fewer is refused
  double max_tilt_deg = 30;  // of a fitted plane from `normal`, where that is given
  static std::span<const Field> fields();
};

/// Points far from their neighbours, compared with how far points are from theirs in the whole cloud.
struct StatisticalRule {
  std::int64_t neighbours = 8;
  double deviations = 3;
  static std::span<const Field> fields();
};

struct OutlierRules {
  std::optional<StatisticalRule> statistical;
  std::optional<double> min_component_points;  // smaller pieces go
  std::optional<double> min_component_share;   // of the points; smaller pieces go
  std::int64_t component_range_bins = 1;       // bins this near (on each axis) belong together
  std::optional<double> bin_mm;                // edge of the bins these rules work on; the job's bin edge when empty
  static std::span<const Field> fields();
  bool any() const { return statistical || min_component_points || min_component_share; }
};

struct Params {
  std::optional<Box> keep_box;
  std::vector<Box> remove_box;
  std::optional<PlaneRule> remove_plane;
  std::optional<OutlierRules> outliers;

  bool any() const { return keep_box || !remove_box.empty() || remove_plane || (outliers && outliers->any()); }
  /// One sentence per value that cannot be.
  std::vector<std::string> problems() const;
};

}  // namespace scanmill::clean
