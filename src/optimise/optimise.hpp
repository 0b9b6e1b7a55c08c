// SPDX-License-Identifier: Apache-2.0
// Edge swaps on a finished mesh (Bradley 2001, section 4.3): the other diagonal of the quadrilateral around an edge.
#pragma once
#include <cstdint>

#include "base/context.hpp"
#include "base/result.hpp"
#include "mesh/mesh.hpp"
#include "optimise/params.hpp"

namespace scanmill::optimise {

/// Edges that a swap would still improve when the pass has ended, by the guard that holds them.
struct Refused {
  std::uint64_t patch_border = 0;  // its two triangles belong to two patches
  std::uint64_t not_convex = 0;    // the quadrilateral, in its mean plane
  std::uint64_t range = 0;         // g1
  std::uint64_t angle = 0;         // g2
  std::uint64_t fold = 0;          // an angle beyond 120 degrees between neighbouring normals that was not there
  std::uint64_t edge_exists = 0;   // the other diagonal is an edge already, or ends where several fans meet
  std::uint64_t crossing = 0;      // a new triangle would cross another one
};

struct PassReport {
  bool done = false;  // asked for
  std::uint64_t rounds = 0, swaps = 0;
  Refused refused;
  double angle_p5_before_deg = 0, angle_p5_after_deg = 0;  // 5th percentile over triangles of their smallest angle
  double longest_edge_mm = 0;                              // afterwards
};

/// How sharply the surface bends over its inner edges.
struct Creases {
  std::uint64_t inner_edges = 0;
  double dihedral_sum_deg = 0;  // of the angles between the normals of neighbours
  std::uint64_t sharp_edges = 0;
  double sharp_length_mm = 0;       // edges above kSharpDegrees
  double normal_variation_rms = 0;  // of |n - n'| over the inner edges
};
inline constexpr double kSharpDegrees = 30;

struct Report {
  PassReport smooth, feature;
  Creases before_feature, after_feature;  // zero when the feature pass is not asked for
};

/// Swaps edges, first *smooth* (the smallest interior angle of the two triangles grows), then *feature* (normals vary
/// less among the two triangles and their four neighbours), each until no swap is left. Vertices, the number of
/// triangles and every topology count stay.
///
/// mesh     two-manifold, consistently oriented; on return in the order that mesh.hpp asks for, patch numbers moved
///          along. Where it is not manifold, nothing is touched. A swap never crosses a patch border, so borders stay.
/// rounds   synchronous: all edges in question are judged against the mesh as it is; each improving swap claims its two
///          triangles and their neighbours; the best by (gain, vertices of the edge) wins; winners swap together. Every
///          decision depends on a bounded neighbourhood, so a mesh cut in pieces gives the same when strips are
///          exchanged after each round.
/// guards   see Refused. A mesh without crossing triangles keeps none: exact predicates decide.
/// errors   BadParameter when a limit is none; Unsupported above 1.07e9 triangles; Cancelled (the mesh is as it was)
/// ends     each swap of a pass moves one potential of the triangulation strictly one way (smooth.hpp, feature.hpp)
/// cost     O(F) memory, about 200 bytes per triangle; each round costs what its changes cost
Result<Report> optimise(Mesh& mesh, const Params& params, const Limits& limits, const Context& context);

}  // namespace scanmill::optimise
