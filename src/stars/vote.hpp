// SPDX-License-Identifier: Apache-2.0
// Which triangles all three corners propose, and which side of the surface is which. Internal to `stars`.
#pragma once
#include <vector>

#include "stars/star.hpp"

namespace scanmill::stars {

/// A triangle with the number of stars that hold it; corners ordered along the signs found.
struct Candidate {
  Triangle corners;
  int votes = 0;
  double radius = 0;  // circumradius on projected positions, mm
};

struct Vote {
  std::vector<Triangle> confirmed;    // oriented; ascending
  std::vector<Candidate> candidates;  // oriented; in the order in which completion tries them
  std::vector<Vec3> normal;           // signs consistent over each component
  std::vector<std::uint8_t> sign_known;
};

/// Confirmed triangles have all three votes and no angle below g2 (those become candidates and are counted). Signs
/// spread over confirmed triangles, flattest links first, so that one bad triangle at a crease cannot turn a whole
/// face; then over star neighbours between components; last by the majority of known view directions.
Vote count_votes(const SurfacePoints& points, const std::vector<Star>& stars, double cos_min_angle,
                 RefusalCounts& refused, const Context& context);

/// Circumradius; 1e30 for triangles without area.
double circumradius(Vec3 a, Vec3 b, Vec3 c);

}  // namespace scanmill::stars
