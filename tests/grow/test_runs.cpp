// SPDX-License-Identifier: Apache-2.0
// Searches over boxes, against asking every pair.
#include <gtest/gtest.h>

#include <numeric>

#include "base/random.hpp"
#include "grow/runs.hpp"

namespace scanmill::grow {
namespace {

/// Points in lines along a grid (many equal distances) or anywhere.
std::vector<Vec3> scattered(std::size_t count, bool on_grid, std::uint64_t seed) {
  Random random(seed, 0, 0);
  std::vector<Vec3> points;
  for (std::size_t n = 0; n < count; ++n) {
    auto axis = [&] { return on_grid ? static_cast<double>(random.next() % 12) : random.uniform(0, 12); };
    points.push_back({axis(), axis(), axis()});
  }
  return points;
}

std::uint32_t nearest_one_by_one(std::span<const Vec3> among, Vec3 at) {
  double best = 1e300;
  std::uint32_t nearest = kNoPoint;
  for (std::uint32_t s = 0; s < among.size(); ++s)
    if (const double d = norm2(among[s] - at); d < best) {
      best = d;
      nearest = s;
    }
  return nearest;
}

TEST(NearestSites, AreTheFirstNearestOfAll) {
  for (const bool on_grid : {false, true})
    for (const std::size_t sites : {1u, 2u, 40u, 300u}) {
      const std::vector<Vec3> points = scattered(3000, on_grid, 1), seeds = scattered(sites, on_grid, 2);
      const std::vector<std::uint32_t> nearest = nearest_sites(points, seeds);
      for (std::size_t n = 0; n < points.size(); ++n)
        ASSERT_EQ(nearest[n], nearest_one_by_one(seeds, points[n])) << "point " << n << " of " << sites << " sites";
    }
}

TEST(NearestSites, OfNoPointsAreNone) { EXPECT_TRUE(nearest_sites({}, scattered(3, false, 1)).empty()); }

TEST(NearestPoint, IsTheFirstNearestOfAll) {
  for (const bool on_grid : {false, true}) {
    const std::vector<Vec3> points = scattered(2000, on_grid, 3);
    const Runs runs(points);
    for (const Vec3 at : scattered(200, on_grid, 4))
      ASSERT_EQ(nearest_point(runs, points, at), nearest_one_by_one(points, at));
    EXPECT_EQ(nearest_point(runs, points, {1e200, 0, 0}), kNoPoint);
  }
  EXPECT_EQ(nearest_point(Runs({}), {}, {}), kNoPoint);
}

TEST(SpacedApart, TakesWhatNoEarlierOneShadows) {
  for (const bool on_grid : {false, true}) {
    const std::vector<Vec3> points = scattered(2500, on_grid, 5);
    std::vector<std::uint32_t> order(points.size());
    std::iota(order.begin(), order.end(), 0u);
    std::reverse(order.begin(), order.end());
    for (const double spacing2 : {0.5, 4.0, 1000.0}) {
      std::vector<std::uint32_t> expected;
      for (const std::uint32_t k : order)
        if (std::none_of(expected.begin(), expected.end(),
                         [&](std::uint32_t s) { return norm2(points[s] - points[k]) < spacing2; }))
          expected.push_back(k);
      EXPECT_EQ(spaced_apart(points, order, spacing2), expected);
    }
  }
  EXPECT_TRUE(spaced_apart({}, {}, 1).empty());
}

}  // namespace
}  // namespace scanmill::grow
