// SPDX-License-Identifier: Apache-2.0
// A tree of boxes over the triangles of a mesh, for rays.
//
// Boxes are split by surface area (Wald 2007, 16 slices per axis) into leaves of at most four triangles; four boxes
// stand side by side in a node. Boxes are float32 and wider than what they hold by more than any rounding of a ray, so
// they rule out and never decide; triangles are met in double by signed volumes, whose signs agree on both sides of an
// edge, so that no ray slips through between two triangles.
#pragma once
#include <cstdint>
#include <vector>

#include "mesh/mesh.hpp"
#include "simulate/trace.hpp"

namespace scanmill::simulate {

class RayTree {
 public:
  /// Over a mesh with rows in range and finite positions; its offset is added. The mesh is copied (76 bytes a
  /// triangle). cost  O(F log F), about 1 us per triangle
  explicit RayTree(const Mesh& mesh);

  struct Hit {
    double t = 0;
    std::uint32_t triangle = kNoTriangle;  // row in mesh.triangles
  };
  /// The nearest triangle that the ray meets with t in `range`, from either side; of several at the same (computed) t
  /// the one with the least number; kNoTriangle when there is none. Any thread may ask.
  Hit first(const Ray& ray, Interval range) const;
  /// Unit normal by the right-hand rule of the triangle's corners; (0, 0, 1) without area.
  Vec3 normal(std::uint32_t triangle) const { return normals_[triangle]; }
  const Bounds& bounds() const { return bounds_; }
  std::size_t triangle_count() const { return normals_.size(); }

 private:
  static constexpr std::uint32_t kWidth = 4;
  struct alignas(16) Node {
    float low[3][kWidth], high[3][kWidth];
    std::uint32_t child[kWidth], count[kWidth];  // triangles from child on, or the node when count is 0
  };
  struct Corner {
    Vec3 a, b, c;
    std::uint32_t triangle;
  };
  class Builder;

  void meet(const Corner& corner, const Ray& ray, Interval range, Hit& best) const;

  std::vector<Node> nodes_;
  std::vector<Corner> corners_;  // in leaf order
  std::vector<Vec3> normals_;    // by row of the mesh
  Bounds bounds_;
  Vec3 centre_;       // boxes are about it
  float margin_ = 0;  // mm; how much wider boxes are
};

}  // namespace scanmill::simulate
