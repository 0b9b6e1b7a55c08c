// SPDX-License-Identifier: Apache-2.0
// Growth on sheets small enough to draw.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

#include "grow/grow.hpp"
#include "support/meshing.hpp"

namespace scanmill::grow {
namespace {

/// Squares of two triangles where `there(i, j)`, over vertices (i, j, height).
struct Sheet {
  std::vector<Vec3> positions;
  std::vector<Triangle> triangles;
  std::vector<float> variation;

  template <class There, class Height>
  Sheet(int columns, int rows, There there, Height height) {
    const auto at = [&](int i, int j) { return static_cast<std::uint32_t>(i * (rows + 1) + j); };
    for (int i = 0; i <= columns; ++i)
      for (int j = 0; j <= rows; ++j) positions.push_back({double(i), double(j), height(i, j)});
    for (int i = 0; i < columns; ++i)
      for (int j = 0; j < rows; ++j) {
        if (!there(i, j)) continue;
        triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
        triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
      }
    variation.assign(positions.size(), 0);
  }
  Input input(double g3, std::int64_t least = 1) const { return {1, positions, {}, variation, triangles, g3, least}; }
};

Result<Patches> grow(const Sheet& sheet, const SeedParams& seeds, double g3 = 0, std::int64_t least = 1) {
  const support::Workers workers;
  return grow_patches(sheet.input(g3, least), seeds, workers.context());
}

std::size_t unlabelled(const Patches& patches) {
  return static_cast<std::size_t>(std::count(patches.patch.begin(), patches.patch.end(), kNoTriangle));
}

TEST(GrowPatches, NearestSeedTakesATriangle) {
  const Sheet sheet(
      10, 4, [](int, int) { return true; }, [](int, int) { return 0.0; });
  const auto patches = grow(sheet, {{{0.1, 2, 0}, {9.9, 2, 0}}, 30, true});
  ASSERT_TRUE(patches.ok());
  ASSERT_EQ(patches->patches.size(), 2u);
  for (std::size_t t = 0; t < sheet.triangles.size(); ++t)
    EXPECT_EQ(patches->patch[t], sheet.positions[sheet.triangles[t][0]].x < 5 ? 0u : 1u) << t;
  EXPECT_EQ(patches->patches[0].area_mm2, 20);
  EXPECT_EQ(patches->patches[0].border_mm, 5 + 4 + 5 + 4);
}

/// A horseshoe whose ends lie close together: the far end of each arm is nearer to the other arm's seed, yet not
/// reached from it without leaving its own part.
///
///   B b b b b b ...
///                 |     the slot is one square wide
///   A a a a a a ...
Sheet horseshoe() {
  return Sheet(
      12, 3, [](int i, int j) { return j != 1 || i == 11; }, [](int, int) { return 0.0; });
}

TEST(GrowPatches, WhatIsCutOffFromItsSeedStaysInTheMesh) {
  const Sheet sheet = horseshoe();
  // Both seeds on the lower arm: the upper arm above the first is nearer to it, but is reached through the second's
  // part.
  const SeedParams seeds{{{0.5, 0.5, 0}, {11.5, 0.5, 0}}, 30, true};
  SeedParams bare = seeds;
  bare.cover = false;
  const auto covered = grow(sheet, seeds), reached = grow(sheet, bare);
  ASSERT_TRUE(covered.ok() && reached.ok());
  EXPECT_EQ(unlabelled(*covered), 0u);
  EXPECT_EQ(covered->patches.size(), 2u);
  EXPECT_EQ(unlabelled(*reached), 0u) << "the seeds reach all of it";
  EXPECT_EQ(reached->patch, covered->patch);
}

TEST(GrowPatches, WithoutCoverKeepsOnlyWhatIsReached) {
  // Two plateaus with an upright wall between them.
  const Sheet sheet(
      10, 4, [](int, int) { return true; }, [](int i, int) { return i < 5 ? 0.0 : 6.0; });
  const auto all = grow(sheet, {{{1, 2, 0}}, 30, true}, 0.9);
  ASSERT_TRUE(all.ok());
  EXPECT_EQ(unlabelled(*all), 0u);
  ASSERT_EQ(all->patches.size(), 2u) << "the wall is a crease strip and joins a plateau";
  EXPECT_EQ(all->patches[1].origin, SeedOrigin::Component);
  EXPECT_EQ(all->refused_normal, 8u);
  const auto one = grow(sheet, {{{1, 2, 0}}, 30, false}, 0.9);
  ASSERT_TRUE(one.ok());
  ASSERT_EQ(one->patches.size(), 1u);
  EXPECT_EQ(one->patches[0].triangles, 32u);
  EXPECT_EQ(unlabelled(*one), 48u);
}

TEST(GrowPatches, NeedsSeedsToLeaveThingsOut) {
  const Sheet sheet = horseshoe();
  const auto patches = grow(sheet, {{}, 30, false});
  ASSERT_FALSE(patches.ok());
  EXPECT_EQ(patches.error().code, Code::BadParameter);
}

TEST(GrowPatches, AutomaticSeedsStandOnPeaksApart) {
  Sheet sheet(
      40, 6, [](int, int) { return true; }, [](int, int) { return 0.0; });
  const auto peak = [&](int i, int j, float height) { sheet.variation[static_cast<std::size_t>(i * 7 + j)] = height; };
  peak(5, 3, 0.2f);
  peak(12, 3, 0.1f);  // too near the first
  peak(35, 3, 0.15f);
  const auto patches = grow(sheet, {{}, 10, true});
  ASSERT_TRUE(patches.ok());
  ASSERT_EQ(patches->patches.size(), 2u);
  EXPECT_EQ(patches->patches[0].seed, (Vec3{5, 3, 0}));
  EXPECT_EQ(patches->patches[1].seed, (Vec3{35, 3, 0}));
  EXPECT_EQ(patches->patches[0].origin, SeedOrigin::Automatic);
}

using Edge = std::pair<std::uint32_t, std::uint32_t>;

/// The border edges, each once, against the edges of the polylines.
void expect_borders_cover(const std::vector<Triangle>& triangles, const std::vector<std::uint32_t>& patch,
                          std::size_t vertices) {
  std::map<Edge, std::vector<std::uint32_t>> sides;
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (std::size_t e = 0; e < 3; ++e) {
      const std::uint32_t a = triangles[t][e], b = triangles[t][(e + 1) % 3];
      sides[{std::min(a, b), std::max(a, b)}].push_back(patch[t]);
    }
  std::multiset<Edge> wanted, got;
  for (const auto& [edge, labels] : sides)
    if (labels.size() == 1 || labels[0] != labels[1]) wanted.insert(edge);
  for (const auto& line : patch_borders(triangles, patch, vertices)) {
    ASSERT_GE(line.size(), 2u);
    for (std::size_t k = 0; k + 1 < line.size(); ++k)
      got.insert({std::min(line[k], line[k + 1]), std::max(line[k], line[k + 1])});
  }
  EXPECT_EQ(got, wanted);
}

TEST(PatchBorders, CoverEveryBorderEdgeOnce) {
  const Sheet sheet(
      9, 7, [](int i, int j) { return !(i == 4 && j == 3); }, [](int, int) { return 0.0; });
  for (const std::uint32_t kinds : {1u, 2u, 3u, 5u}) {
    std::vector<std::uint32_t> patch;
    for (std::size_t t = 0; t < sheet.triangles.size(); ++t)
      patch.push_back(static_cast<std::uint32_t>((t * 2654435761u >> 7) % kinds));
    expect_borders_cover(sheet.triangles, patch, sheet.positions.size());
  }
  const auto lines =
      patch_borders(sheet.triangles, std::vector<std::uint32_t>(sheet.triangles.size(), 0), sheet.positions.size());
  ASSERT_EQ(lines.size(), 2u) << "rim and hole";
  for (const auto& line : lines) EXPECT_EQ(line.front(), line.back());
  EXPECT_TRUE(patch_borders({}, {}, 0).empty());
}

}  // namespace
}  // namespace scanmill::grow
