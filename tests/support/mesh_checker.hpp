// SPDX-License-Identifier: Apache-2.0
// A judge of meshes that shares nothing with src/: brute force over maps, crossings in integers.
#pragma once
#include <cstddef>
#include <cstdint>
#include <iosfwd>
#include <span>
#include <string>

#include "mesh/mesh.hpp"

namespace scanmill::support {

struct MeshFindings {
  std::size_t vertices = 0, triangles = 0, edges = 0;
  // These are zero on every sound mesh.
  std::size_t nonmanifold_edges = 0, nonmanifold_vertices = 0, misoriented_edges = 0, duplicate_triangles = 0;
  std::size_t degenerate_triangles = 0, crossing_pairs = 0, long_edges = 0, small_angles = 0, bad_indices = 0;
  // These describe it.
  std::size_t boundary_edges = 0, loops = 0, components = 0;
  std::int64_t euler = 0;
  double area = 0, volume = 0, longest_edge = 0, least_angle_deg = 180;
  std::string first_fault;  // one of the crossings, long edges, ... by numbers, for the reader of a failure

  bool sound() const {
    return nonmanifold_edges + nonmanifold_vertices + misoriented_edges + duplicate_triangles + degenerate_triangles +
               crossing_pairs + long_edges + small_angles + bad_indices ==
           0;
  }
};
std::ostream& operator<<(std::ostream& out, const MeshFindings& findings);

/// Crossing: two triangles share a point outside their common vertices and edges. Positions must lie on the grid of
/// shapes.hpp below 2048 mm (a coordinate that does not is a bad index, so that no test passes unjudged).
MeshFindings check_mesh(std::span<const Vec3> positions, std::span<const Triangle> triangles, double longest_mm,
                        double least_angle_deg);

}  // namespace scanmill::support
