// SPDX-License-Identifier: Apache-2.0
// How slender triangles are. Internal to `optimise`.
#pragma once
#include <algorithm>
#include <functional>
#include <vector>

#include "base/context.hpp"
#include "geom/angles.hpp"
#include "mesh/mesh.hpp"
#include "optimise/smooth.hpp"

namespace scanmill::optimise {

struct Shapes {
  std::vector<double> cos2;  // per triangle: squared cosine of its smallest angle
  double longest2 = 0;       // squared length of the longest edge, mm2
};

/// corners(n): of the n-th triangle.
template <class Corners>
Shapes shapes_of(std::span<const Vec3> at, std::size_t count, const Corners& corners, const Context& context) {
  constexpr std::size_t kGrain = 8192;
  Shapes shapes{std::vector<double>(count), 0};
  std::vector<double> longest2((count + kGrain - 1) / kGrain, 0);
  for_each_piece(context, count, kGrain, [&](std::size_t begin, std::size_t end, std::size_t piece, int) {
    for (std::size_t n = begin; n < end; ++n) {
      const Triangle& v = corners(n);
      const Vec3 a = at[v[0]], b = at[v[1]], c = at[v[2]];
      const double x = norm2(a - b), y = norm2(b - c), z = norm2(c - a);
      shapes.cos2[n] = smallest_angle_cos2(x, y, z);
      longest2[piece] = std::max({longest2[piece], x, y, z});
    }
  });
  for (const double piece : longest2) shapes.longest2 = std::max(shapes.longest2, piece);
  return shapes;
}

inline Shapes shapes_of(const Surface& surface, const Context& context) {
  return shapes_of(
      surface.positions(), surface.slot_count(),
      [&](std::size_t t) -> const Triangle& { return surface.slot(static_cast<std::uint32_t>(t)).corner; }, context);
}

/// The smallest angle that 5 % of the triangles stay below; 0 without triangles.
inline double fifth_percentile_deg(std::vector<double> cos2) {
  if (cos2.empty()) return 0;
  const auto fifth = cos2.begin() + static_cast<std::ptrdiff_t>(cos2.size() / 20);
  std::nth_element(cos2.begin(), fifth, cos2.end(), std::greater<>());
  return acos_degrees(std::sqrt(*fifth));
}

}  // namespace scanmill::optimise
