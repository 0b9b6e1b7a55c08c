// SPDX-License-Identifier: Apache-2.0
// Which triangles all three corners propose, and which side of the surface is which. Internal to `stars`.
#pragma once
#include <vector>

#include "stars/star.hpp"

namespace scanmill::stars {

struct Vote {
  std::vector<Triangle> confirmed;    // oriented; ascending
  std::vector<Candidate> candidates;  // oriented; in the order in which completion tries them
  std::vector<Vec3> normal;           // signs consistent over each component
  std::vector<std::uint8_t> sign_known;
};

/// What the stars of own rows say, as one ballot or several in the order of rows, without links. Triangles that all
/// three hold, but with an angle below g2, are candidates, and are counted.
std::vector<Ballot> ballots_of(const SurfacePoints& points, const std::vector<Star>& stars, std::span<const Role> roles,
                               double cos_min_angle, const Context& context);
/// The links that one ballot over all of `stars` leaves; those of a part's own rows.
std::vector<std::array<std::uint32_t, 2>> links_of(const std::vector<Star>& stars, std::span<const Role> roles,
                                                   const std::vector<Ballot>& ballots);

/// Signs spread over agreed triangles, flattest links first, so that one bad triangle at a crease cannot turn a whole
/// face; then over star neighbours between components; last by the majority of known view directions. `stars`: whose
/// neighbours are the links; without them the ballots' own are.
Vote count_votes(const SurfacePoints& points, const std::vector<Ballot>& ballots, const std::vector<Star>* stars);

/// Circumradius; 1e30 for triangles without area.
double circumradius(Vec3 a, Vec3 b, Vec3 c);

}  // namespace scanmill::stars
