// SPDX-License-Identifier: Apache-2.0
// Edge swaps part by part: a brick's mesh with the mesh around it, and whether neighbours saw the same.
//
// Every decision of a round depends on a bounded neighbourhood, so a part that knows the mesh around its own far enough
// decides as the whole does, but near its rim, where triangles are missing, it may go wrong, and what is wrong wanders
// inwards round by round. So nothing is assumed: each part writes down what happened in every block of the lattice, and
// a part is right when, in all blocks that its own decisions can depend on, it saw just what the owners of these blocks
// saw. If that holds for all parts, it holds by induction over the rounds that all of them did what the whole does.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "base/context.hpp"
#include "base/result.hpp"
#include "mesh/mesh.hpp"
#include "optimise/creases.hpp"
#include "optimise/optimise.hpp"

namespace scanmill::optimise {

/// A block of the lattice, four bins wide, by its place.
using Block = std::array<std::int32_t, 3>;
inline constexpr std::int32_t kBlockBins = 4;

/// Vertices of some bricks and those around them, with all triangles among them, in the order of mesh.hpp.
struct Part {
  Mesh mesh;
  std::vector<std::uint32_t> vertex;  // of each vertex: its number among all, ascending
  std::vector<std::uint8_t> own;      // of each vertex: 1 when it is of the bricks
  std::vector<Block> block;           // of each vertex; a block belongs to one part
  double block_mm = 1;                // edge of a block
  double reach_mm = 0;                // every vertex at most so far from an own one, along each axis, is there
};

/// What was decided about the edges at a block's vertices, between two looks at the edges that triangles hold.
struct Events {
  Block block{};
  std::uint16_t pass = 0, turn = 0;
  std::uint32_t swaps = 0;
  std::uint64_t sum = 0;  // over (round, edge, decision), in any order
};

/// A round in which the part swapped an edge of its own.
struct Round {
  std::uint32_t pass = 0, turn = 0, round = 0;
  bool operator==(const Round&) const = default;
  auto operator<=>(const Round&) const = default;
};

/// Over edges whose lesser vertex is own, and triangles whose least one is.
struct PartTally {
  std::array<std::uint64_t, 2> swaps{};
  std::array<std::uint32_t, 2> turns{};
  std::array<Refused, 2> refused{};
  std::array<double, 2> longest2{};
  CreaseSums before_feature, after_feature;
  std::uint64_t is_sure = 0;  // the part reaches far enough for its triangles
};

struct SwappedPart {
  std::vector<Triangle> triangles;   // whose least vertex is own, numbers among all, order of mesh.hpp
  std::vector<std::uint32_t> patch;  // of each
  std::vector<double> between;       // per own triangle between two passes: squared cosine of its smallest angle
  std::vector<Round> rounds;         // ascending
  std::vector<Events> events;        // ascending (block, pass, turn); own blocks and those watched
  std::vector<Block> own, watched;   // blocks: its own; those of others that its decisions can depend on; ascending
  PartTally tally;
};

/// errors  those of optimise()
/// cost    that of optimise() for the part
Result<SwappedPart> optimise_part(const Part& part, const Params& params, const Limits& limits, const Context& context);

/// What of a part is needed to see whether it is right.
struct Account {
  std::vector<Events> events;
  std::vector<Block> own, watched;
  std::array<std::uint32_t, 2> turns{};
  bool is_sure = false;
};
/// Every part saw what the owners of the blocks around it saw.
bool agree(std::span<const Account> accounts);

/// The tallies of parts, as optimise() would have reported. `mesh`: as it is now; `before`: its triangles as they were.
class PartReports {
 public:
  void add(const PartTally& tally, std::span<const Round> rounds, std::span<const double> between);
  Report report(std::span<const Triangle> before, const Mesh& mesh, const Params& params, const Limits& limits,
                const Context& context);

 private:
  PartTally sum_;
  std::vector<Round> rounds_;
  std::vector<double> between_;
};

}  // namespace scanmill::optimise
