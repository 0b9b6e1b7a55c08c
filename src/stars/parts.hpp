// SPDX-License-Identifier: Apache-2.0
// Stars in parts, for clouds that are worked on by several processes: what the stars of some rows say, found from these
// rows and those around them, and the mesh from what all rows say. The same, to the last bit, as mesh_points gives,
// however the rows are cut.
#pragma once
#include <array>
#include <span>
#include <vector>

#include "stars/stars.hpp"

namespace scanmill::stars {

/// Bins around a brick whose points its ballot looks at, and those of them whose stars it needs.
inline constexpr std::int32_t kStarHalo = 4, kStarReach = 2;

/// What a row is to the part it is in.
enum class Role : std::uint8_t {
  Around,  // a neighbour of neighbours; no star of it is asked for
  Near,    // within kStarReach of an own row
  Own
};

/// A triangle with the number of stars that hold it.
struct Candidate {
  Triangle corners;
  int votes = 0;
  double radius = 0;  // circumradius on projected positions, mm
};

/// A triangle all three stars hold. Opposite: the star of that corner turns the other way round than that of corner 0.
struct Agreed {
  Triangle corners;
  std::uint8_t a_opposite = 0, b_opposite = 0;
  std::uint8_t rank = 0;  // of flatness, 0 best
  std::uint8_t none = 0;
};

/// What the stars of some rows say, in the order of these rows. Candidates run as the star of their first corner does.
struct Ballot {
  std::vector<Agreed> agreed;
  std::vector<Candidate> candidates;
  std::vector<std::array<std::uint32_t, 2>> links;  // star neighbours that no agreed triangle of the ballot joins
  RefusalCounts refused;
};

/// points    own rows, and all others within kStarHalo bins of them, ascending keys
/// roles     per row
/// returns   the own rows' ballot, in the numbering of `points`
/// errors    as mesh_points
Result<Ballot> ballot_of(const SurfacePoints& points, std::span<const Role> roles, const Params& params,
                         const Context& context);

/// points    all
/// ballots   of runs of rows one after the other, in the numbering of `points`
Result<Surface> mesh_ballots(const SurfacePoints& points, std::vector<Ballot> ballots, const Params& params,
                             const Context& context, Progress& progress);

}  // namespace scanmill::stars
