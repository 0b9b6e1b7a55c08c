// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>

#include "verify/compare.hpp"
#include "verify/meshes.hpp"

namespace scanmill::verify {
namespace {

TEST(CompareMeshes, OfAMeshWithItselfFindsNothing) {
  const Mesh mesh = cube();
  const auto found = compare_meshes(mesh, mesh, Workers().context());
  ASSERT_TRUE(found.ok());
  EXPECT_TRUE(found->identical && found->same_vertices && found->same_triangles);
  EXPECT_EQ(found->a.vertices.max_mm, 0);
  EXPECT_LT(found->a.surface.max_mm, 1e-15);
  EXPECT_EQ(found->volume_difference_mm3, 0);
  EXPECT_NEAR(found->a.volume_mm3, 1, 1e-15);
  EXPECT_NEAR(found->b.area_mm2, 6, 1e-15);
}

TEST(CompareMeshes, MeasuresBothWays) {
  // A sheet of 4 x 4 and the same with a quarter gone: seen from the whole, places over the gap are far.
  const Mesh whole = flat_sheet(4, 1);
  Mesh part = whole;
  std::erase_if(part.triangles, [&](const Triangle& t) {
    Vec3 sum;
    for (const std::uint32_t v : t) sum += whole.positions[v];
    return sum.x > 6 && sum.y > 6;
  });
  part.patch.clear();
  const auto found = compare_meshes(whole, part, Workers().context());
  ASSERT_TRUE(found.ok());
  EXPECT_NEAR(found->a.vertices.max_mm, 2, 1e-15);  // the corner (4, 4) from (2, 4)
  EXPECT_EQ(found->a.vertices.worst, (Vec3{4, 4, 0}));
  EXPECT_EQ(found->b.vertices.max_mm, 0);
  EXPECT_LT(found->b.surface.max_mm, 1e-15);
  EXPECT_NEAR(found->area_difference_mm2, -4, 1e-12);
  // Even over the area: of the gap's square of edge 2 the distance to its two sides is min(x, y); its mean square over
  // the gap is 2/3, and the gap is a quarter.
  EXPECT_NEAR(found->a.surface.rms_mm, std::sqrt(2.0 / 3 / 4), 0.01);
  EXPECT_EQ(found->triangles_in_both, part.triangles.size());
  EXPECT_FALSE(found->same_triangles);
}

TEST(CompareMeshes, KnowsTheSameMeshInAnotherOrder) {
  const Mesh a = cube();
  Mesh b = a;
  std::reverse(b.positions.begin(), b.positions.end());
  for (Triangle& t : b.triangles) t = {7 - t[1], 7 - t[2], 7 - t[0]};
  std::reverse(b.triangles.begin(), b.triangles.end());
  auto found = compare_meshes(a, b, Workers().context());
  ASSERT_TRUE(found.ok());
  EXPECT_TRUE(found->same_vertices && found->same_triangles);
  EXPECT_FALSE(found->identical);
  std::swap(b.triangles[3][0], b.triangles[3][1]);  // turned over
  found = compare_meshes(a, b, Workers().context());
  EXPECT_FALSE(found->same_triangles);
  EXPECT_EQ(found->triangles_in_both, 11u);
}

TEST(CompareMeshes, AddsOffsets) {
  Mesh a = cube(), b = a;
  for (Vec3& p : b.positions) p -= Vec3{4096, 0, 0};
  b.offset = {4096, 0, 0};
  const auto found = compare_meshes(a, b, Workers().context());
  ASSERT_TRUE(found.ok());
  EXPECT_TRUE(found->same_triangles);
  EXPECT_EQ(found->b.vertices.max_mm, 0);
}

TEST(CompareMeshes, DoesNotDependOnThreads) {
  const Mesh a = sheet(60, 0.3, [](double x, double y) { return 0.1 * x * y; });
  const Mesh b = sheet(50, 0.36, [](double x, double y) { return 0.1 * x * y + 0.01 * x; });
  std::vector<Comparison> all;
  for (const int threads : {1, 2, 7}) {
    const Workers workers(threads);
    auto found = compare_meshes(a, b, workers.context());
    ASSERT_TRUE(found.ok());
    all.push_back(*found);
  }
  for (const Comparison& found : all) {
    EXPECT_EQ(found.a.surface.rms_mm, all[0].a.surface.rms_mm);
    EXPECT_EQ(found.b.surface.p99_mm, all[0].b.surface.p99_mm);
    EXPECT_EQ(found.b.vertices.worst, all[0].b.vertices.worst);
  }
}

TEST(CompareMeshes, SaysWhichMeshIsNone) {
  Mesh empty;
  const auto found = compare_meshes(cube(), empty, Workers().context());
  ASSERT_FALSE(found.ok());
  EXPECT_EQ(found.error().code, Code::BadInput);
  EXPECT_NE(found.error().text().find("second mesh"), std::string::npos);
}

}  // namespace
}  // namespace scanmill::verify
