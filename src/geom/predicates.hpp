// SPDX-License-Identifier: Apache-2.0
// Exact predicates on doubles: a filter first, expansions where it cannot tell (Shewchuk 1997). No FMA, no tolerance.
#pragma once
#include <array>

#include "geom/vec3.hpp"

namespace scanmill {

/// Sign of det(b-a, c-a, d-a): +1 when d lies on the side that the normal of (a, b, c) points to, 0 when coplanar.
int orientation(Vec3 a, Vec3 b, Vec3 c, Vec3 d);

/// Sign of the area of (a, b, c) dropped to the plane without `axis` (0 x, 1 y, 2 z).
int orientation_flat(Vec3 a, Vec3 b, Vec3 c, int axis);

/// Closed segment pq and closed triangle abc share a point.
bool segment_meets_triangle(Vec3 p, Vec3 q, Vec3 a, Vec3 b, Vec3 c);

/// Corners of a triangle with the ids by which shared vertices are known.
struct Corners {
  std::array<Vec3, 3> at;
  std::array<unsigned, 3> id;
};

/// Two triangles of a mesh meet outside their shared vertices and edges, or are folded flat over a shared edge.
/// Touching counts as meeting. Triangles without area meet nothing. The same triangle twice: true.
bool triangles_cross(const Corners& s, const Corners& t);

}  // namespace scanmill
