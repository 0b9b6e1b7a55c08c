// SPDX-License-Identifier: Apache-2.0
// Which triangles lie on which edge, for meshes that may be anything. Internal to `verify`.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "mesh/mesh.hpp"

namespace scanmill::verify {

/// A triangle that names a vertex twice has no edges.
inline bool names_a_vertex_twice(const Triangle& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; }

/// What lies across a corner's edge (from corner e of triangle t to corner e+1, at 3 t + e): a triangle, or one of
/// these.
inline constexpr std::uint32_t kOpenEdge = 0xffffffffu;     // no other triangle
inline constexpr std::uint32_t kCrowdedEdge = 0xfffffffeu;  // more than one
inline constexpr std::uint32_t kNoEdge = 0xfffffffdu;       // of a triangle that names a vertex twice
/// Numbers of triangles end here.
inline constexpr std::uint32_t kMostTriangles = 0x55555555u;

/// Corners 3 t + e by edge: edge n has corners[first[n]] to corners[first[n + 1] - 1], ascending; edges by lesser
/// vertex, then greater. cost  O(F) and 28 bytes per triangle
struct Edges {
  std::vector<std::uint32_t> first, corners;
  std::size_t size() const { return first.size() - 1; }
  std::span<const std::uint32_t> at(std::size_t edge) const {
    return {corners.data() + first[edge], corners.data() + first[edge + 1]};
  }
};
Edges edges_of(std::size_t vertex_count, std::span<const Triangle> triangles);

/// Per corner: the triangle across its edge, kOpenEdge, kCrowdedEdge or kNoEdge.
std::vector<std::uint32_t> across_of(const Edges& edges, std::size_t triangle_count);

}  // namespace scanmill::verify
