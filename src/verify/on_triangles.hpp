// SPDX-License-Identifier: Apache-2.0
// Which triangle of a mesh each point of a cloud is nearest to.
#pragma once
#include <cstdint>
#include <vector>

#include "base/context.hpp"
#include "base/result.hpp"
#include "cloud/cloud.hpp"
#include "mesh/mesh.hpp"

namespace scanmill::verify {

struct PointsOnTriangles {
  std::vector<Vec3> places;  // frame of the mesh: offset taken off; in the order of the cloud
  std::vector<std::uint32_t> triangle;
  std::uint64_t step = 1;      // every step-th row was taken
  std::uint64_t left_out = 0;  // taken, but nearest to an open edge, or farther off than `reach_mm`
};

/// The points of a cloud with their nearest triangles, evenly thinned where the cloud is expected to hold more than
/// `most`.
/// errors  those of the source; BadInput when no triangle has an area; Cancelled
/// cost    one pass over the cloud; 28 bytes per point
Result<PointsOnTriangles> points_on_triangles(const Mesh& mesh, const PointSource& points, double reach_mm,
                                              std::uint64_t most, const Context& context);

}  // namespace scanmill::verify
