// SPDX-License-Identifier: Apache-2.0
// Seeds and limits through the whole stage: a sampled solid, reduced, meshed, grown.
#include <gtest/gtest.h>

#include <algorithm>

#include "simulate/object.hpp"
#include "support/meshing.hpp"
#include "support/shapes.hpp"

namespace scanmill::grow {
namespace {

using support::Meshed;

constexpr double kHalf = 15;  // mm: half the edge of the built-in cube
constexpr Vec3 kCentre{0.3, -0.2, 0.1};

std::vector<Vec3> sampled(const char* object, std::size_t count) {
  const auto made = simulate::make_object(object);
  return simulate::sample_surface(**made, count, 5);
}

const std::vector<Vec3>& cube_points() {
  static const std::vector<Vec3> points = sampled("cube", 90000);
  return points;
}

std::vector<Vec3> face_centres() {
  std::vector<Vec3> list{{kHalf, 0, 0}, {-kHalf, 0, 0}, {0, kHalf, 0}, {0, -kHalf, 0}, {0, 0, kHalf}, {0, 0, -kHalf}};
  for (Vec3& p : list) p += kCentre;
  return list;
}

double to_nearest_edge(Vec3 p) {
  p -= kCentre;
  double off[3] = {std::abs(std::abs(p.x) - kHalf), std::abs(std::abs(p.y) - kHalf), std::abs(std::abs(p.z) - kHalf)};
  std::sort(off, off + 3);
  return std::sqrt(off[0] * off[0] + off[1] * off[1]);
}

void expect_labels_and_ranks(const Meshed& meshed) {
  const auto& s = meshed.surface;
  std::vector<std::vector<std::uint32_t>> ranks(s.patches.patches.size());
  ASSERT_EQ(s.mesh.patch.size(), s.mesh.triangles.size());
  for (std::size_t t = 0; t < s.mesh.patch.size(); ++t) {
    ASSERT_LT(s.mesh.patch[t], ranks.size());
    ranks[s.mesh.patch[t]].push_back(s.patches.rank[t]);
  }
  for (std::size_t p = 0; p < ranks.size(); ++p) {
    EXPECT_EQ(ranks[p].size(), s.patches.patches[p].triangles) << "patch " << p;
    std::sort(ranks[p].begin(), ranks[p].end());
    for (std::uint32_t k = 0; k < ranks[p].size(); ++k) ASSERT_EQ(ranks[p][k], k) << "patch " << p;
  }
}

TEST(GrowPatches, SixSeedsOnACubeGiveItsFaces) {
  pipeline::What what = support::what_of(1.0);
  what.grow.min_normal_dot = 0.9;
  what.seeds.points = face_centres();
  const auto meshed = support::mesh_points(cube_points(), what);
  ASSERT_TRUE(meshed.ok()) << meshed.error().text();
  const auto& s = meshed->surface;
  ASSERT_EQ(s.patches.patches.size(), 6u);
  for (const Patch& patch : s.patches.patches) {
    EXPECT_EQ(patch.origin, SeedOrigin::Given);
    EXPECT_NEAR(patch.area_mm2, 900, 90);
  }
  ASSERT_GE(s.borders.size(), 12u);
  for (const auto& line : s.borders)
    for (const std::uint32_t v : line) EXPECT_LE(to_nearest_edge(s.mesh.positions[v]), 1.5) << "vertex " << v;
  expect_labels_and_ranks(*meshed);
}

TEST(GrowPatches, OneSeedWithoutCoverGivesItsFaceAlone) {
  for (const Vec3 seed : face_centres()) {
    pipeline::What what = support::what_of(1.0);
    what.grow.min_normal_dot = 0.9;
    what.seeds.points = {seed};
    what.seeds.cover = false;
    const auto meshed = support::mesh_points(cube_points(), what);
    ASSERT_TRUE(meshed.ok()) << meshed.error().text();
    const Vec3 out = unit(seed - kCentre);
    for (const Vec3 p : meshed->surface.mesh.positions) ASSERT_LE(std::abs(dot(p - seed, out)), 1.5);
    const auto found = support::check_mesh(meshed->surface.mesh.positions, meshed->surface.mesh.triangles, 2.5, 5);
    EXPECT_NEAR(found.area, 900, 90);
    EXPECT_EQ(found.components, 1u);
    EXPECT_EQ(found.nonmanifold_vertices, 0u);
    EXPECT_EQ(found.loops, 1u);
    ASSERT_EQ(meshed->surface.patches.patches.size(), 1u);
    EXPECT_EQ(meshed->surface.patches.patches[0].triangles, found.triangles);
    expect_labels_and_ranks(*meshed);
  }
}

/// On rough data the seed's reach ends in bow ties; what is taken away there leaves no gap in the ranks.
TEST(GrowPatches, RanksStayWholeWhereFansAreCut) {
  pipeline::What what = support::what_of(0.7);
  what.grow.min_normal_dot = 0.9;
  what.seeds.cover = false;
  const std::vector<Vec3> points = support::with_noise(cube_points(), 0.1, 3);
  for (const Vec3 seed : face_centres()) {
    what.seeds.points = {seed};
    const auto meshed = support::mesh_points(points, what);
    ASSERT_TRUE(meshed.ok()) << meshed.error().text();
    const auto found = support::judge(*meshed, what);
    EXPECT_TRUE(found.sound()) << found;
    EXPECT_NEAR(meshed->surface.patches.patches[0].area_mm2, found.area, 1e-6 * found.area);
    expect_labels_and_ranks(*meshed);
  }
}

TEST(GrowPatches, SixSeedsOnAFigurineGiveSixPatches) {
  pipeline::What what = support::what_of(1.0);
  const std::vector<Vec3> points = sampled("figurine", 120000);
  for (std::size_t n = 0; n < 6; ++n) what.seeds.points.push_back(points[n * 17]);
  const auto meshed = support::mesh_points(points, what);
  ASSERT_TRUE(meshed.ok()) << meshed.error().text();
  EXPECT_EQ(meshed->surface.patches.patches.size(), 6u);
  for (const Patch& patch : meshed->surface.patches.patches) EXPECT_EQ(patch.origin, SeedOrigin::Given);
  expect_labels_and_ranks(*meshed);
}

TEST(GrowPatches, EveryLimitChangesTheMeshAndItsOwnCount) {
  const pipeline::What what = support::what_of(1.0);
  const auto base = support::mesh_points(cube_points(), what);
  ASSERT_TRUE(base.ok());
  const RefusalCounts& before = base->surface.refused;
  pipeline::What g1 = what, g2 = what, g3 = what;
  g1.grow.range_bins = 1.5;
  g2.grow.min_angle_deg = 30;
  g3.grow.min_normal_dot = 0.9;
  const auto by_g1 = support::mesh_points(cube_points(), g1), by_g2 = support::mesh_points(cube_points(), g2);
  const auto by_g3 = support::mesh_points(cube_points(), g3);
  ASSERT_TRUE(by_g1.ok() && by_g2.ok() && by_g3.ok());
  EXPECT_NE(by_g1->surface.mesh.triangles, base->surface.mesh.triangles);
  EXPECT_GT(by_g1->surface.refused.range, before.range);
  EXPECT_NE(by_g2->surface.mesh.triangles, base->surface.mesh.triangles);
  EXPECT_GT(by_g2->surface.refused.angle, before.angle);
  EXPECT_EQ(by_g3->surface.mesh.triangles, base->surface.mesh.triangles) << "g3 shapes patches, it tears no holes";
  EXPECT_GT(by_g3->surface.patches.patches.size(), base->surface.patches.patches.size());
  EXPECT_GT(by_g3->surface.refused.normal, before.normal);
}

TEST(GrowPatches, SaysHowFarASeedIsOff) {
  pipeline::What what = support::what_of(1.0);
  what.seeds.points = {kCentre + Vec3{0, 0, kHalf}, kCentre + Vec3{0, 0, kHalf + 40}};
  const auto meshed = support::mesh_points(cube_points(), what);
  ASSERT_FALSE(meshed.ok());
  EXPECT_EQ(meshed.error().code, Code::BadParameter);
  EXPECT_NE(meshed.error().text().find("seed 2"), std::string::npos) << meshed.error().text();
  EXPECT_NE(meshed.error().text().find("40"), std::string::npos) << meshed.error().text();
  EXPECT_NE(meshed.error().text().find("10 mm"), std::string::npos) << meshed.error().text();
}

}  // namespace
}  // namespace scanmill::grow
