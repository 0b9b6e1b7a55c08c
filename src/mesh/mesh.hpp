// SPDX-License-Identifier: Apache-2.0
// The triangle mesh every stage after growth hands on, and the walks all of them need.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "base/ids.hpp"
#include "geom/vec3.hpp"

namespace scanmill {

/// Vertex rows in outward counter-clockwise order; the smallest row first.
using Triangle = std::array<std::uint32_t, 3>;

/// Vertices in ascending bin key; triangles in ascending (rows). Positions are exactly what a float32 file will hold
/// once `offset` is added back: position = float32(measured - offset), as double, mm.
struct Mesh {
  std::vector<Vec3> positions;
  std::vector<Triangle> triangles;
  std::vector<std::uint32_t> patch;  // per triangle; PatchId
  Vec3 offset;                       // mm; zero unless float32 would cost more than h/1000
};

/// One closed walk over open edges, in the direction of the missing triangles' edges; starts at its least row.
struct BorderLoop {
  std::vector<std::uint32_t> vertices;
  double length_mm = 0;
  Vec3 centre;  // mean of the vertices, mm, global frame
};

/// Triangles across each edge: neighbour[3 t + e] is the triangle over the edge from corner e to corner e+1, or
/// kNoTriangle where there is none or more than one.
inline constexpr std::uint32_t kNoTriangle = 0xffffffffu;
std::vector<std::uint32_t> edge_neighbours(std::size_t vertex_count, std::span<const Triangle> triangles);

/// All boundary loops, ordered by least vertex row. At a vertex where several loops meet, each turns to its own fan's
/// end. Ends on every mesh; where triangles disagree in direction, a loop runs as its first open half-edge says.
std::vector<BorderLoop> border_loops(const Mesh& mesh);

/// Counts that a sound mesh keeps at zero, and those that describe it. A triangle that names a vertex twice has no edges
/// but counts otherwise. Cost O(F log F).
struct TopologyCounts {
  std::uint64_t vertices_used = 0, triangles = 0, edges = 0, boundary_edges = 0, boundary_loops = 0;
  std::uint64_t nonmanifold_edges = 0, nonmanifold_vertices = 0, misoriented_edges = 0, components = 0;
  std::int64_t euler = 0;
};
TopologyCounts topology_of(const Mesh& mesh);

/// Per triangle: stays when every vertex is to have one fan. Where a vertex has several, the largest stays (ties: the
/// one with the least triangle number), again until nothing changes.
std::vector<std::uint8_t> single_fan_triangles(std::size_t vertex_count, std::span<const Triangle> triangles);

/// Sum of signed tetrahedra over the origin, mm3.
double signed_volume(const Mesh& mesh);

}  // namespace scanmill
