// SPDX-License-Identifier: Apache-2.0
// Would a swap make triangles cross, or give an edge twice? Internal to `optimise`.
//
// The two old and the two new triangles bound the tetrahedron a b c d. In a mesh without crossings, a triangle meets
// the new ones only if one of its edges meets the tetrahedron (a triangle that cuts it without an edge inside also cuts
// an old side). Edges near it are sorted out by codes against the sides and corners of an upright prism around it, as a
// line clipper does; what the codes cannot tell is decided by exact predicates.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "optimise/near.hpp"
#include "optimise/surface.hpp"

namespace scanmill::optimise {

enum class Obstacle : std::uint8_t { None, EdgeExists, Crossing };

/// A swap that is to happen in this round.
struct Winner {
  std::uint32_t half;
  float gain;
  Quad quad;
};

class CrossingGuard {
 public:
  CrossingGuard(const Surface& surface, const NearVertices& near) : surface_(surface), near_(near) {}

  /// winner_of[t]: the winner that swaps slot t, or kNone. Judged against the mesh as it is; `rivals` gets the winners
  /// whose new triangles cross this one's new ones, or who bring the same edge, once or several times.
  Obstacle judge(std::uint32_t self, std::span<const Winner> winners, std::span<const std::uint32_t> winner_of,
                 std::vector<std::uint32_t>& rivals) const;

 private:
  const Surface& surface_;
  const NearVertices& near_;
};

}  // namespace scanmill::optimise
