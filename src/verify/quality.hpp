// SPDX-License-Identifier: Apache-2.0
// What a mesh is, without any cloud: topology, crossings, angles, sizes, pieces, borders. For any mesh, sound or not.
#pragma once
#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "base/context.hpp"
#include "base/result.hpp"
#include "mesh/mesh.hpp"

namespace scanmill::verify {

/// A piece of the mesh: triangles that share vertices.
struct Component {
  std::uint64_t triangles = 0, vertices = 0;
  double area_mm2 = 0;
  Bounds bounds;               // global frame, mm
  std::uint32_t first_vertex;  // its least vertex row
};

/// Two triangles that meet outside their shared vertices and edges, or are folded flat over a shared edge.
struct Crossing {
  std::uint32_t first = 0, second = 0;  // triangle numbers, first < second
  Vec3 place;                           // middle of where their boxes overlap, global frame, mm
};

/// Smallest interior angle of every triangle, degrees; without area: 0. Percentile q is the value of rank floor(q (n -
/// 1)).
struct AngleFigures {
  double least = 0, p1 = 0, p5 = 0, p50 = 0, mean = 0;
  std::array<std::uint64_t, 60> histogram{};  // by whole degrees; 60 itself counts in the last
};

/// Over the three sides of every triangle (an edge between two triangles counts twice), mm.
struct EdgeFigures {
  double least = 0, p50 = 0, p99 = 0, greatest = 0;
};

struct Quality {
  TopologyCounts topology;
  std::uint64_t vertices_unused = 0;
  std::uint64_t repeated_corners = 0;     // triangles that name a vertex twice
  std::uint64_t zero_area_triangles = 0;  // twice the area at most 1e-14 mm2
  std::uint64_t duplicate_triangles = 0;  // the same three vertices as an earlier one, in any order
  std::uint64_t edge_components = 0;      // triangles connected over edges
  double largest_component_share = 0;     // of the triangles, by edges
  bool orientable = true, closed_manifold = false;
  AngleFigures angles;
  EdgeFigures edges;
  double area_mm2 = 0, volume_mm3 = 0;  // signed, over the origin of the mesh's own frame
  Bounds bounds;                        // of the used vertices, global frame
  std::vector<Component> components;    // most triangles first, then least vertex
  std::vector<BorderLoop> loops;        // border_loops: where more than two triangles share an edge it counts as open
  std::uint64_t crossing_pairs = 0, crossing_triangles = 0;
  std::vector<Crossing> crossings;  // the first 100 by triangle numbers
};

/// Looks at any mesh. Crossings by exact predicates; triangles that name a vertex twice or have no area cross nothing,
/// and two with the same three vertices are counted as duplicates only. Same result for any number of threads.
///
/// errors  BadInput when a triangle names a vertex that is not there, or a position is not finite or beyond float32;
///         Unsupported above 2^32/3 triangles; Cancelled
/// cost    about 2 us and 200 bytes per triangle
Result<Quality> quality_of(const Mesh& mesh, const Context& context);

/// What every function of this module asks of a mesh: rows in range, positions finite.
Result<void> check_mesh(const Mesh& mesh);

}  // namespace scanmill::verify
