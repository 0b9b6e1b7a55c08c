// SPDX-License-Identifier: Apache-2.0
// A flat tree of boxes over the triangles of a mesh. Internal to `verify`.
//
// Triangles are split by the median of their centroids into leaves of eight; four leaves make a node, four nodes the
// next, so that the place of every node follows from its number and nothing points anywhere. Boxes are float32, rounded
// outwards: they rule out, they never decide.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "geom/vec3.hpp"
#include "mesh/mesh.hpp"

namespace scanmill::verify {

inline constexpr std::size_t kLeaf = 8;

/// Box in float32 that holds another in double.
struct FloatBox {
  float low[3], high[3];
};
FloatBox holding(const Bounds& box);

class BoxTree {
 public:
  /// Four boxes side by side; missing ones are empty (nothing meets them).
  struct alignas(16) Node {
    float low[3][4], high[3][4];
  };

  /// Over these triangles of the mesh, in any order; there may be none.
  BoxTree(const Mesh& mesh, std::vector<std::uint32_t> triangles);

  /// Triangles in leaf order; the last leaf may be short.
  std::span<const std::uint32_t> triangles() const { return order_; }
  std::size_t leaf_count() const { return (order_.size() + kLeaf - 1) / kLeaf; }
  /// Nodes over leaves (level 0: node n has leaves 4 n to 4 n + 3), over those (level 1), up to a single root.
  std::span<const std::vector<Node>> levels() const { return levels_; }
  std::size_t memory_bytes() const;

  /// Leaves whose box meets `box`, ascending within a node but else in no stated order, appended; false when more than
  /// `most` were found (some are then missing).
  bool leaves_meeting(const FloatBox& box, std::size_t most, std::vector<std::uint32_t>& leaves) const;

 private:
  std::vector<std::uint32_t> order_;
  std::vector<std::vector<Node>> levels_;
};

}  // namespace scanmill::verify
