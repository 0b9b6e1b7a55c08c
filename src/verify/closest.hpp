// SPDX-License-Identifier: Apache-2.0
// The nearest place of one triangle.
#pragma once
#include <cstdint>

#include "geom/vec3.hpp"

namespace scanmill::verify {

/// Where on a triangle the nearest place lies.
enum class Feature : std::uint8_t { Face, EdgeAB, EdgeBC, EdgeCA, CornerA, CornerB, CornerC };

struct Closest {
  double distance2 = 0;  // mm2
  Feature feature = Feature::Face;
};

/// Nearest place of the closed triangle (a, b, c) to p, by the region p lies in. A triangle as flat as rounding (sine
/// at a below 1e-8, or two corners in one place) counts as its three sides; of equally near sides the first. source  C.
/// Ericson, Real-Time Collision Detection (2005), section 5.1.5, for the regions
Closest closest_on_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c);

/// The same bits where p lies over the inside of a triangle that is not flat.
inline double distance2_over_face(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 n = cross(b - a, c - a);
  const double height = dot(p - a, n);
  return height * height / norm2(n);
}

}  // namespace scanmill::verify
