// SPDX-License-Identifier: Apache-2.0
// Patches: what each seed reaches over triangles that satisfy g1, g2, g3 (Bradley 2001, section 4.2).
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "base/context.hpp"
#include "base/result.hpp"
#include "grow/params.hpp"
#include "mesh/limits.hpp"
#include "mesh/mesh.hpp"

namespace scanmill::grow {

struct Input {
  double edge_mm = 1;
  std::span<const Vec3> positions;      // per vertex, mm, as written
  Vec3 offset;                          // seeds are given in the global frame = positions + offset
  std::span<const float> variation;     // per vertex: curvature proxy, 0..1/3
  std::span<const Triangle> triangles;  // two-manifold, consistently oriented
  double min_normal_dot = 0;            // g3
  std::int64_t min_patch_triangles = 10;
};

enum class SeedOrigin : std::uint8_t { Given, Automatic, Component };
const char* name_of(SeedOrigin origin);

struct Patch {
  Vec3 seed;  // global frame, mm
  SeedOrigin origin = SeedOrigin::Automatic;
  std::uint64_t triangles = 0;
  double area_mm2 = 0;
  double border_mm = 0;  // edges to other patches and open edges
};

struct Patches {
  std::vector<std::uint32_t> patch;  // per triangle; kNoTriangle: not reached and `cover` is false
  std::vector<std::uint32_t> rank;   // per triangle: its place in its patch by distance from the seed
  std::vector<Patch> patches;        // in order of seeds: given, automatic, components
  std::uint64_t refused_normal = 0;  // edges that g3 closed
};

/// Label triangles by patch.
///
/// errors  BadParameter when a given seed is farther than 10 bins from every triangle's centroid (says which and how
///         far), or when `cover` is false without given seeds
/// ties    a triangle of a component with several seeds: nearest centroid (squared distance, seed number); what is cut
///         off or too small joins over the flattest edge (dot, patch number)
/// cost    about 0.6 us per triangle
Result<Patches> grow_patches(const Input& input, const SeedParams& seeds, const Context& context);

/// Edges where patches meet or the mesh ends, chained to polylines of vertices; closed ones repeat their first vertex.
std::vector<std::vector<std::uint32_t>> patch_borders(std::span<const Triangle> triangles,
                                                      std::span<const std::uint32_t> patch, std::size_t vertex_count);

}  // namespace scanmill::grow
