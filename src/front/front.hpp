// SPDX-License-Identifier: Apache-2.0
// `engine: front`: the paper's patch growth taken literally, for reference and for small parts.
//
// Problem: grow triangles over reduced points, one patch per seed, so that no gap wider than g1 is bridged.
// Source: C. Bradley, Computers in Industry 44 (2001), section 4.2: all points sorted by distance from the seed; the
// first triangle from the first three; each next point is joined to the nearest vertex of the patch's boundary and its
// neighbour, first forward round the boundary until a triangle is refused, then in reverse; interior points of finished
// patches leave the set, their boundary points stay. Where the text is open, we decide (measured reasons in
// docs/algorithm.md): g1 holds for every edge; the local normal is the mean of the patch's triangles that touch the
// ends of the boundary edge; g3 is a least cosine; the first triangle is the first valid triple by distance; refused
// points are tried again until a pass adds nothing; ties go to (squared distance, row); a triangle that would lie over
// or cut through another is refused; two boundary edges that meet are closed to a triangle ("ear") when it passes
// g1-g3; at the end a vertex keeps only its largest fan. We differ in one promise: every edge has at most two
// triangles, oppositely directed, on any input.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "base/context.hpp"
#include "base/result.hpp"
#include "geom/vec3.hpp"
#include "mesh/limits.hpp"
#include "mesh/mesh.hpp"

namespace scanmill::front {

/// Growth visits every point in every pass and looks through every neighbour: fine for reference, hopeless for
/// millions.
inline constexpr std::size_t kMaxPoints = 50000;

struct Input {
  std::span<const Vec3> points;  // mm, rows in ascending key
  double edge_mm = 1;            // bin edge
  GrowthLimits limits;
  std::vector<Vec3> seeds;        // mm; empty: automatic
  std::span<const Vec3> normals;  // per point, unit, any sign; may be empty
  std::size_t max_patches = 1000;
};

struct Output {
  /// Smallest row first, ascending; consistently oriented within a patch and across seams.
  std::vector<Triangle> triangles;
  std::vector<std::uint32_t> patch;   // per triangle, row of seed_points
  std::vector<Vec3> seed_points;      // mm; seeds that grew a patch, in order
  RefusalCounts refused;              // triangles a point was refused, by the first limit that refused
  std::uint64_t refused_overlap = 0;  // passed g1-g3, but an edge was taken or the triangle would overlap another
};

/// Automatic seeds: the points where normals vary most, at a distance from each other, then whatever is still
/// uncovered.
///
/// errors  Unsupported above kMaxPoints; BadParameter when edge_mm is not positive; Internal naming the first point
///         that is not finite, or when normals and points differ in length; Cancelled
/// cost    serial; about 0.1 ms per point
Result<Output> grow_fronts(const Input& input, const Context& context);

}  // namespace scanmill::front
