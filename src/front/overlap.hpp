// SPDX-License-Identifier: Apache-2.0
// Does a new triangle lie over another one, or cut through it? (The paper speaks of visibility in the plane only.)
#pragma once
#include <array>
#include <cstdint>

#include "geom/vec3.hpp"

namespace scanmill::front {

/// A triangle as the test needs it.
struct Facet {
  std::array<Vec3, 3> corners;
  Vec3 normal;                          // unit
  std::array<std::uint32_t, 3> rows{};  // to know which corners two triangles share
};

/// True when the two cut each other away from shared corners, or when they are within 60 degrees of parallel, closer
/// than `clearance`, and their projections on a's plane share more than a rim of width `tolerance` (all mm). Plain
/// double arithmetic: a guard, not a proof.
bool overlap(const Facet& a, const Facet& b, double clearance, double tolerance);

}  // namespace scanmill::front
