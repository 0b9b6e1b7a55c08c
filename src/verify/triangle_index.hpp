// SPDX-License-Identifier: Apache-2.0
// The nearest triangle of a mesh to any point, exactly.
//
// Plain float32 bounds (boxes of leaves; the planes through a triangle's face and sides, four triangles at once) rule
// triangles out with a margin for their rounding; what remains is measured in double by closest_on_triangle. The answer
// is that of measuring every triangle, to the last bit. Points that follow one another closely share one walk down the
// tree.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "mesh/mesh.hpp"
#include "verify/box_tree.hpp"
#include "verify/closest.hpp"

namespace scanmill::verify {

/// The nearest triangle; of several at the same (computed) squared distance the one with the least number.
struct Hit {
  double distance2 = 0;  // mm2
  std::uint32_t triangle = 0;
  Feature feature = Feature::Face;
};

/// Over a mesh with all rows in range and positions finite; it must outlive the index. Frame of the mesh: offset not
/// added. Triangles without area (their normal is exactly zero) are no surface and are never the nearest. Any thread
/// may search; cost about 85 bytes per triangle and O(F log F).
class TriangleIndex {
 public:
  explicit TriangleIndex(const Mesh& mesh);

  const Mesh& mesh() const { return *mesh_; }
  /// No triangle has an area; nothing may be asked then.
  bool empty() const { return leaves_.empty(); }
  const BoxTree& tree() const { return tree_; }
  std::size_t memory_bytes() const;
  /// Mean diagonal of the boxes of eight neighbouring triangles, mm: what counts as near for a search.
  double leaf_size() const { return leaf_size_; }

  /// Searches one after the other, remembering where the last ones ended; answers do not depend on that. One per
  /// thread.
  class Search {
   public:
    explicit Search(const TriangleIndex& index);
    /// hits[n] for points[n]: finite, below 1e15 mm. Fast when neighbours in the list are neighbours in space.
    void nearest(std::span<const Vec3> points, std::span<Hit> hits);
    Hit nearest(Vec3 point);

   private:
    struct Best;
    std::size_t run_length(std::span<const Vec3> points, Bounds& box) const;
    bool gather(const Bounds& box);
    void among_gathered(const Vec3& p, Best& best) const;
    void walk(const Vec3& p, Best& best) const;
    void try_leaf(std::uint32_t leaf, const Vec3& p, Best& best) const;
    void measure(std::uint32_t triangle, bool over_face, std::uint32_t leaf, const Vec3& p, Best& best) const;

    const TriangleIndex* index_;
    double reach_;  // mm; how far around a run its leaves are gathered
    std::uint32_t last_leaf_ = 0;
    std::vector<std::uint32_t> leaves_;
    std::vector<BoxTree::Node> boxes_;
  };

 private:
  /// Planes through face, ab, bc and ca of eight triangles, about the leaf's origin: value = x nx + y ny + z nz - w,
  /// for the sides positive outside. All zero: not ruled out by it.
  struct alignas(16) Leaf {
    float plane[2][4][4][4];  // half, plane, component, lane
    float origin[3], radius;
    std::uint32_t triangle[kLeaf];
  };
  void fill(std::size_t number, Leaf& leaf) const;

  const Mesh* mesh_;
  BoxTree tree_;
  std::vector<Leaf> leaves_;
  double leaf_size_ = 0;
};

}  // namespace scanmill::verify
