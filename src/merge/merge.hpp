// SPDX-License-Identifier: Apache-2.0
// One mesh out of all triangles: stray components dropped, sides turned outward, vertices numbered by bin key.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "merge/params.hpp"
#include "mesh/mesh.hpp"

namespace scanmill::merge {

struct Input {
  std::span<const Vec3> positions;  // per row, as written, mm, relative to offset
  Vec3 offset;
  std::span<const std::uint8_t> side_known;  // per row: views told the side of its component
  std::span<const Triangle> triangles;       // rows; two-manifold, consistently oriented
  std::span<const std::uint32_t> patch;      // per triangle; may be empty
};

/// A component that was dropped.
struct Stray {
  std::uint64_t triangles = 0, vertices = 0;
  Bounds bounds;  // global frame, mm
};

struct Merged {
  Mesh mesh;                              // patch as given, in the mesh's order of triangles
  std::vector<std::uint32_t> vertex_row;  // per vertex
  std::vector<Stray> strays;              // largest first
  std::vector<std::uint32_t> stray_rows;  // rows behind the vertices of all strays, ascending
  std::uint64_t components = 0, turned_components = 0, turned_by_volume = 0;
};

/// Components below min_component_share of all triangles are dropped (the largest never is). A component whose side the
/// views do not tell is turned so that it encloses a positive volume about the middle of its box; a flat sheet across
/// an axis (ground seen from the air) so that it shows that axis's positive side.
Merged merge_components(const Input& input, const Params& params);

}  // namespace scanmill::merge
