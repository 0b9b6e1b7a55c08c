// SPDX-License-Identifier: Apache-2.0
// Two meshes against each other.
#pragma once
#include <cstdint>

#include "base/context.hpp"
#include "base/result.hpp"
#include "mesh/mesh.hpp"

namespace scanmill::verify {

/// Unsigned distances of places on one mesh from the other, mm; p99 is the value of rank floor(0.99 (n - 1)).
struct Deviation {
  std::uint64_t places = 0;
  double max_mm = 0, rms_mm = 0, mean_mm = 0, p99_mm = 0;
  Vec3 worst;  // where max_mm was found: on the first mesh, global frame; the first such place
};

struct Side {
  TopologyCounts topology;
  double area_mm2 = 0, volume_mm3 = 0;  // volume over the middle of both meshes' box: of use for closed meshes
  Deviation vertices;                   // of its used vertices from the other mesh
  Deviation surface;                    // of places spread evenly over its area
};

struct Comparison {
  Side a, b;
  double area_difference_mm2 = 0, volume_difference_mm3 = 0;  // b less a
  // As sets, by position (the same place in the global frame to the last bit) and, for triangles, by the cycle of their
  // corners: turned over is different. Repeated ones count as often as they stand.
  std::uint64_t vertices_in_both = 0, triangles_in_both = 0;
  bool same_vertices = false, same_triangles = false;
  bool identical = false;  // the same numbers in the same order: positions, triangles, offset (patches do not matter)
};

/// Both ways: vertices, and a systematic sample of each surface: four places per triangle of the mesh, at least 10,000
/// and at most 4,000,000, at equal steps of area in the order of triangles, each at a random place of its triangle from
/// a fixed seed. Same result for any number of threads.
///
/// errors  BadInput when a mesh has no triangle with an area or check_mesh refuses it; Cancelled
/// cost    about 2 us per place
Result<Comparison> compare_meshes(const Mesh& a, const Mesh& b, const Context& context);

}  // namespace scanmill::verify
