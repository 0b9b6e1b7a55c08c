// SPDX-License-Identifier: Apache-2.0
// A coarser mesh to be looked at, never to be measured: by cells of a cubic grid.
#pragma once
#include <cstdint>
#include <utility>
#include <vector>

#include "mesh/mesh.hpp"

namespace scanmill {

struct CoarserMesh {
  std::vector<std::uint32_t> row_of;    // per row of `vertex`: which vertex of the fine mesh stands there
  std::vector<std::uint32_t> vertex;    // per vertex of the fine mesh: its row of `row_of`
  std::vector<Triangle> triangles;      // of rows of `row_of`, ascending, the smallest row first
  std::vector<std::uint32_t> triangle;  // per triangle: the least fine one that became it
  double cell_mm = 0;                   // edge of the grid's cells; 0: nothing was left out
};

/// As it is when it has at most `most_triangles` (at least 8); else every vertex becomes the one nearest to the centre
/// of its cell, and triangles whose corners fell together or that are there already go; what is folded over by this
/// is turned, so that the outside stays outside. The grid starts at the box's low corner with as many cells along the
/// longest side as the area lets expect, and becomes coarser by the root of the excess until the limit holds.
/// ties  the least vertex row, the least triangle number
/// cost  O((V log V + F log F) tries), two tries as a rule; about 40 bytes per triangle
CoarserMesh coarser_mesh(const Mesh& mesh, std::uint64_t most_triangles);

/// Edges that do not join exactly two triangles, as rising pairs of vertices, ascending.
std::vector<std::pair<std::uint32_t, std::uint32_t>> open_edges(const Mesh& mesh);

}  // namespace scanmill
