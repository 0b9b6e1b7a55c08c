// SPDX-License-Identifier: Apache-2.0
// The judge of the property tests, judged on meshes small enough to see.
#include <gtest/gtest.h>

#include "support/mesh_checker.hpp"

namespace scanmill::support {
namespace {

const std::vector<Vec3> kTetrahedron{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
const std::vector<Triangle> kOutward{{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};

MeshFindings check(const std::vector<Vec3>& at, const std::vector<Triangle>& faces) {
  return check_mesh(at, faces, 10, 1);
}

TEST(MeshChecker, PassesATetrahedron) {
  const MeshFindings found = check(kTetrahedron, kOutward);
  EXPECT_TRUE(found.sound()) << found;
  EXPECT_EQ(found.euler, 2);
  EXPECT_EQ(found.boundary_edges, 0u);
  EXPECT_EQ(found.components, 1u);
  EXPECT_NEAR(found.volume, 1.0 / 6, 1e-15);
}

TEST(MeshChecker, SeesEachFault) {
  std::vector<Triangle> turned = kOutward;
  std::swap(turned[0][1], turned[0][2]);
  EXPECT_EQ(check(kTetrahedron, turned).misoriented_edges, 3u);

  std::vector<Triangle> twice = kOutward;
  twice.push_back({1, 0, 2});
  EXPECT_EQ(check(kTetrahedron, twice).duplicate_triangles, 1u);
  EXPECT_EQ(check(kTetrahedron, twice).nonmanifold_edges, 3u);

  EXPECT_EQ(check_mesh(kTetrahedron, kOutward, 1.2, 1).long_edges, 6u);
  EXPECT_EQ(check_mesh(kTetrahedron, kOutward, 10, 50).small_angles, 6u);

  // Two triangles that touch in one vertex only.
  const std::vector<Vec3> bow{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}};
  const MeshFindings tied = check(bow, {{0, 1, 2}, {0, 3, 4}});
  EXPECT_EQ(tied.nonmanifold_vertices, 1u);
  EXPECT_EQ(tied.crossing_pairs, 0u);
  EXPECT_EQ(check(bow, {{0, 1, 2}}).loops, 1u);

  EXPECT_EQ(check({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {{0, 1, 2}}).degenerate_triangles, 1u);
  EXPECT_EQ(check(kTetrahedron, {{0, 1, 9}}).bad_indices, 1u);
  EXPECT_EQ(check({{0.1, 0, 0}, {1, 0, 0}, {2, 1, 0}}, {{0, 1, 2}}).bad_indices, 1u);
}

TEST(MeshChecker, SeesEveryWayOfCrossing) {
  const Vec3 a{0, 0, 0}, b{4, 0, 0}, c{0, 4, 0};
  const auto pair = [&](Vec3 p, Vec3 q, Vec3 r) {
    return check({a, b, c, p, q, r}, {{0, 1, 2}, {3, 4, 5}}).crossing_pairs;
  };
  EXPECT_EQ(pair({1, 1, -1}, {1, 1, 1}, {8, 8, 1}), 1u);  // through the inside
  EXPECT_EQ(pair({2, 2, 0}, {5, 5, 1}, {5, 5, -1}), 1u);  // a corner on an edge
  EXPECT_EQ(pair({4, 0, 0}, {5, 0, 1}, {5, 1, 1}), 1u);   // a corner on a corner that is not shared
  EXPECT_EQ(pair({1, 1, 0}, {2, 1, 0}, {1, 2, 0}), 1u);   // inside, in the plane
  EXPECT_EQ(pair({5, 5, 0}, {6, 5, 0}, {5, 6, 0}), 0u);   // beside, in the plane
  EXPECT_EQ(pair({1, 1, 0.25}, {2, 1, 0.25}, {1, 2, 0.25}), 0u);

  const auto at_corner = [&](Vec3 p, Vec3 q) { return check({a, b, c, p, q}, {{0, 1, 2}, {0, 3, 4}}).crossing_pairs; };
  EXPECT_EQ(at_corner({-4, 0, 0}, {0, -4, 0}), 0u);
  EXPECT_EQ(at_corner({1, 1, 1}, {1, 1, -1}), 1u);
  EXPECT_EQ(at_corner({8, 1, 0}, {9, 2, 0}), 1u);   // overlapping sectors, in the plane
  EXPECT_EQ(at_corner({8, 0, 0}, {8, -1, 0}), 1u);  // along a side
  EXPECT_EQ(at_corner({1, 1, 1}, {2, 1, 1}), 0u);

  const auto over_edge = [&](Vec3 p) { return check({a, b, c, p}, {{0, 1, 2}, {1, 0, 3}}).crossing_pairs; };
  EXPECT_EQ(over_edge({1, -3, 0}), 0u);
  EXPECT_EQ(over_edge({1, 3, 0}), 1u);  // folded flat
  EXPECT_EQ(over_edge({1, 3, 0.25}), 0u);
}

}  // namespace
}  // namespace scanmill::support
