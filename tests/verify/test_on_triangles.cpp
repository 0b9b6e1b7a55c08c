// SPDX-License-Identifier: Apache-2.0
// Which triangle a point is nearest to, and which points count.
#include <gtest/gtest.h>

#include "verify/on_triangles.hpp"

namespace scanmill::verify {
namespace {

struct Workers {
  explicit Workers(int threads) : loop(threads) {}
  ChunkLoop loop;
  CancelFlag cancel;
  Context context() const { return {loop, cancel}; }
};

/// Four triangles around (0, 0), the outside open; far from the origin by its offset.
Mesh star() {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {10, 0, 0}, {0, 10, 0}, {-10, 0, 0}, {0, -10, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 1}};
  mesh.offset = {1024, 0, 0};
  return mesh;
}

TEST(PointsOnTriangles, KeepTheirOrderAndLeaveOutWhatIsBeyond) {
  const Mesh mesh = star();
  const std::vector<Vec3> places{{1026, 2, 0.3}, {1022, 2, -0.2}, {1040, 3, 0}, {1023, -2, 0.9}, {1025, -2, 1.1}};
  for (const int threads : {1, 2, 7}) {
    const Workers workers(threads);
    const MemoryPoints points(places, {}, 2);
    const auto found = points_on_triangles(mesh, points, 1, 100, workers.context());
    ASSERT_TRUE(found.ok()) << found.error().text();
    EXPECT_EQ(found->triangle, (std::vector<std::uint32_t>{0, 1, 2}));
    EXPECT_EQ(found->places, (std::vector<Vec3>{{2, 2, 0.3}, {-2, 2, -0.2}, {-1, -2, 0.9}}));
    EXPECT_EQ(found->left_out, 2u) << "one beyond the border, one farther off than 1 mm";
    EXPECT_EQ(found->step, 1u);
  }
}

TEST(PointsOnTriangles, TakeEveryFewWhereTheCloudIsLarge) {
  const Workers workers(2);
  const MemoryPoints points(std::vector<Vec3>(1000, {1026, 2, 0}), {}, 64);
  const auto found = points_on_triangles(star(), points, 1, 300, workers.context());
  ASSERT_TRUE(found.ok());
  EXPECT_EQ(found->step, 4u);
  EXPECT_EQ(found->places.size(), 250u);
}

TEST(PointsOnTriangles, RefuseAMeshWithoutArea) {
  Mesh mesh = star();
  mesh.triangles = {{0, 1, 3}};
  const Workers workers(1);
  EXPECT_FALSE(points_on_triangles(mesh, MemoryPoints({{0, 0, 0}}), 1, 10, workers.context()).ok());
}

}  // namespace
}  // namespace scanmill::verify
