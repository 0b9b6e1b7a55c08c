// SPDX-License-Identifier: Apache-2.0
// Edges shared by two triangles and the connected pieces they make: what a boundary representation is built of.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "mesh/mesh.hpp"

namespace scanmill::exporting {

struct Shell {
  std::vector<std::uint32_t> triangles;  // ascending
  bool closed = false;                   // every edge has two triangles, oppositely directed
  double volume_mm3 = 0;                 // of a closed one, by its direction
};

struct Shells {
  std::vector<std::array<std::uint32_t, 2>> edges;        // (low row, high row), ascending
  std::vector<std::array<std::uint32_t, 3>> edge_of;      // per triangle: the edge from corner e to corner e + 1
  std::vector<std::uint32_t> first_triangle;              // per edge: the least
  std::vector<std::uint8_t> used_forward, used_backward;  // per edge: triangles that run low to high, high to low
  std::vector<Shell> shells;                              // by least triangle
  std::uint64_t overused_edges = 0;                       // more than two triangles, or two in one direction
  std::uint32_t first_overused = 0;                       // edge
};

/// Triangles with two equal corners give nothing and belong to no shell.
/// cost  O(F log d), d = triangles at a vertex
Shells shells_of(const Mesh& mesh);

}  // namespace scanmill::exporting
