// SPDX-License-Identifier: Apache-2.0
// g1, g2, g3 (Bradley 2001, section 4.2): the three reasons to refuse a triangle, shared by every stage that makes
// triangles.
#pragma once
#include <cstdint>
#include <optional>
#include <span>

#include "base/fields.hpp"
#include "geom/vec3.hpp"

namespace scanmill {

enum class Engine : std::int32_t { Stars, Front };

/// The job's `grow` section.
struct GrowthLimits {
  double range_bins = 2.5;               // g1, in bin edges; every edge of a triangle, on measured coordinates
  double min_angle_deg = 5;              // g2
  double min_normal_dot = 0;             // g3: least cosine between neighbouring normals
  std::optional<double> max_normal_deg;  // g3 as an angle; wins over min_normal_dot when given
  Engine engine = Engine::Stars;
  static std::span<const Field> fields();
  /// The cosine in force, from max_normal_deg when given.
  double normal_dot() const;
};

enum class Refusal : std::int32_t { None, Range, Angle, Normal };

/// How often each limit refused.
struct RefusalCounts {
  std::uint64_t range = 0, angle = 0, normal = 0;
};

/// g1: true when no edge is longer than `range` (mm).
bool within_range(Vec3 a, Vec3 b, Vec3 c, double range);
/// g2: true when every interior angle is at least the one whose cosine is `cos_min_angle` (both in [0, 60] degrees).
/// Exact comparisons of squared cosines; no trigonometric function.
bool angles_at_least(Vec3 a, Vec3 b, Vec3 c, double cos_min_angle);
/// g3: n_t . n_p >= min_dot for unit normals.
inline bool normals_agree(Vec3 n_t, Vec3 n_p, double min_dot) { return dot(n_t, n_p) >= min_dot; }

/// Cosine by argument reduction and a fixed polynomial: the same bits on every machine (glibc's differs between CPUs).
double cos_of_degrees(double degrees);

}  // namespace scanmill
