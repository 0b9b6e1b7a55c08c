// SPDX-License-Identifier: Apache-2.0
// Corners and normal of a triangle as STL holds them, the same for the binary and the ASCII writer.
#pragma once
#include <cstdint>

#include "export/little_endian.hpp"
#include "mesh/mesh.hpp"

namespace scanmill::exporting {

struct FloatCorner {
  float x, y, z;
};

inline FloatCorner corner_of(const Vec3& p) {
  return {without_minus_zero(static_cast<float>(p.x)), without_minus_zero(static_cast<float>(p.y)),
          without_minus_zero(static_cast<float>(p.z))};
}

/// Zero for a triangle without area, as STL readers expect.
inline FloatCorner normal_of(FloatCorner a, FloatCorner b, FloatCorner c) {
  const Vec3 u{double{b.x} - a.x, double{b.y} - a.y, double{b.z} - a.z};
  const Vec3 v{double{c.x} - a.x, double{c.y} - a.y, double{c.z} - a.z};
  const Vec3 n = cross(u, v);
  const double length = norm(n);
  if (!(length > 0)) return {0, 0, 0};
  return {without_minus_zero(static_cast<float>(n.x / length)), without_minus_zero(static_cast<float>(n.y / length)),
          without_minus_zero(static_cast<float>(n.z / length))};
}

}  // namespace scanmill::exporting
