// SPDX-License-Identifier: Apache-2.0
// On which side of the mesh a point lies, and beside which borders. Internal to `verify`.
//
// The sign of a distance is that of the normal at the nearest place: of the triangle inside a face; the sum of both
// triangles' unit normals on an edge; the sum of the unit normals weighted by their angles at a vertex. Only these give
// the right side next to sharp edges (Baerentzen and Aanaes 2005). On an open or crowded edge the nearest triangle's
// own.
#pragma once
#include <cstdint>
#include <vector>

#include "verify/edges.hpp"
#include "verify/triangle_index.hpp"

namespace scanmill::verify {

class Sides {
 public:
  explicit Sides(const Mesh& mesh);
  /// p in the frame of the mesh; true on the side of the normal, and on the surface.
  bool is_above(const Hit& hit, const Vec3& p) const;
  /// The nearest place lies on an open edge.
  bool at_open_border(const Hit& hit) const;
  /// The nearest triangle has a corner on an edge between two patches.
  bool at_patch_border(const Hit& hit) const { return beside_border_[hit.triangle] != 0; }

 private:
  const Mesh& mesh_;
  std::vector<std::uint32_t> across_;
  std::vector<Vec3> normal_;                 // per vertex, any length
  std::vector<std::uint8_t> on_open_edge_;   // per vertex
  std::vector<std::uint8_t> beside_border_;  // per triangle
};

}  // namespace scanmill::verify
