// SPDX-License-Identifier: Apache-2.0
// One mesh for one cloud: whatever the threads, the order of rows and blocks, the place in space.
#include <gtest/gtest.h>

#include <algorithm>

#include "base/random.hpp"
#include "support/meshing.hpp"
#include "support/shapes.hpp"

namespace scanmill::pipeline {
namespace {

using support::Meshed;

std::vector<Vec3> cloud_of(const char* shape) {
  const auto& known = support::shape_named(shape);
  return support::with_noise(known.points(1.0), 0.15, 3);
}

void expect_same(const Meshed& a, const Meshed& b) {
  EXPECT_EQ(a.surface.mesh.positions, b.surface.mesh.positions);
  EXPECT_EQ(a.surface.mesh.triangles, b.surface.mesh.triangles);
  EXPECT_EQ(a.surface.mesh.patch, b.surface.mesh.patch);
  EXPECT_EQ(a.surface.patches.rank, b.surface.patches.rank);
  EXPECT_EQ(a.surface.borders, b.surface.borders);
  EXPECT_EQ(a.surface.refused.range, b.surface.refused.range);
  EXPECT_EQ(a.surface.refused.angle, b.surface.refused.angle);
  EXPECT_EQ(a.surface.refused.normal, b.surface.refused.normal);
}

class SameMesh : public testing::TestWithParam<const char*> {
 protected:
  SameMesh() { what_.grow.min_normal_dot = 0.8; }
  Meshed mesh(const std::vector<Vec3>& points, int threads = 1, std::size_t block = 65536) const {
    auto meshed = support::mesh_cloud(MemoryPoints(points, {}, block), what_, threads);
    EXPECT_TRUE(meshed.ok());
    return std::move(meshed).value();
  }
  What what_ = support::what_of(1.0);
  std::vector<Vec3> points_ = cloud_of(GetParam());
};

TEST_P(SameMesh, ForAnyNumberOfThreads) {
  const Meshed one = mesh(points_);
  for (const int threads : {2, 7}) expect_same(one, mesh(points_, threads, 777));
}

TEST_P(SameMesh, ForAnyOrderOfRowsAndBlocks) {
  const Meshed one = mesh(points_);
  std::vector<Vec3> shuffled = points_;
  Random random(1, 2, 3);
  for (std::size_t i = shuffled.size(); i > 1; --i) std::swap(shuffled[i - 1], shuffled[random.next() % i]);
  expect_same(one, mesh(shuffled, 2, 1000));
  std::reverse(shuffled.begin(), shuffled.end());
  expect_same(one, mesh(shuffled, 1, 65536));
}

INSTANTIATE_TEST_SUITE_P(Shapes, SameMesh, testing::Values("box", "touching spheres", "noise ball"),
                         [](const auto& instance) {
                           std::string name = instance.param;
                           std::replace(name.begin(), name.end(), ' ', '_');
                           return name;
                         });

/// Ties and the order of rows follow absolute bins, so a moved cloud may break a tie the other way, but nothing more.
TEST(MovedCloud, KeepsItsMeshBesidesTies) {
  const What what = support::what_of(1.0);
  const auto points = support::with_noise(support::shape_named("box").points(1.0), 0.02, 3);
  const Vec3 there{1024.0 * 1024, -1024.0 * 3, 1024.0 * 77};  // float32 alone would cost 0.06 mm here
  std::vector<Vec3> moved = points;
  for (Vec3& p : moved) p += there;
  const auto here = support::mesh_points(points, what), far = support::mesh_points(moved, what);
  ASSERT_TRUE(here.ok() && far.ok());
  EXPECT_NE(far->surface.mesh.offset, Vec3{});
  const auto found = support::judge(*far, what);
  EXPECT_TRUE(found.sound()) << found;
  EXPECT_EQ(found.boundary_edges, 0u);
  const double before = static_cast<double>(here->surface.mesh.positions.size());
  EXPECT_NEAR(static_cast<double>(found.vertices), before, 0.01 * before);
  EXPECT_NEAR(found.volume, signed_volume(here->surface.mesh), 1);
}

TEST(Sides, FollowTheViewsWhereTheyKnow) {
  const auto points = support::with_noise(support::sphere_points({}, 10, 20000, 5), 0, 1);
  const What what = support::what_of(1.0);
  const auto outside = support::mesh_points(points, what);
  const auto inside = support::mesh_cloud(MemoryPoints(points, {Vec3{0, 0, 0}, {}}), what);
  ASSERT_TRUE(outside.ok() && inside.ok());
  EXPECT_GT(signed_volume(outside->surface.mesh), 0);
  EXPECT_LT(signed_volume(inside->surface.mesh), 0) << "seen from the centre only";
}

TEST(MeshSurface, SaysWhenThereIsNoSurface) {
  const What what = support::what_of(0.01);
  const auto meshed = support::mesh_points(support::sphere_points({}, 10, 50, 5), what);
  ASSERT_FALSE(meshed.ok());
  EXPECT_EQ(meshed.error().code, Code::BadInput);
}

}  // namespace
}  // namespace scanmill::pipeline
