// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>

#include "base/random.hpp"
#include "front/overlap.hpp"
#include "front/point_grid.hpp"
#include "front/surface.hpp"

namespace scanmill::front {
namespace {

TEST(PointGrid, FindsWhatBruteForceFinds) {
  for (const double spread : {3.0, 40.0, 1e9}) {
    std::vector<Vec3> points;
    Random random(5, static_cast<std::uint64_t>(spread), 1);
    for (int n = 0; n < 400; ++n) {
      const double x = random.uniform(-spread, spread), y = random.uniform(-spread, spread);
      points.push_back({x, y, n % 5 == 0 ? 0 : random.uniform(-spread, spread)});
    }
    points.push_back(points[7]);
    const PointGrid grid(points, 2.5);
    for (const double radius : {2.5, 1.0, 0.0}) {
      for (std::size_t q = 0; q < points.size(); q += 7) {
        std::vector<std::uint32_t> found, expected;
        grid.each_within(points[q], radius, [&](std::uint32_t row) { found.push_back(row); });
        for (std::uint32_t row = 0; row < points.size(); ++row)
          if (norm2(points[row] - points[q]) <= radius * radius) expected.push_back(row);
        std::sort(found.begin(), found.end());
        EXPECT_EQ(found, expected) << "spread " << spread << " radius " << radius << " point " << q;
      }
    }
  }
}

Facet facet(Vec3 a, Vec3 b, Vec3 c, std::array<std::uint32_t, 3> rows) {
  return {{a, b, c}, unit(cross(b - a, c - a)), rows};
}

/// Both ways round, with clearance 0.5 and tolerance 0.02.
bool meet(const Facet& a, const Facet& b) {
  const bool there = overlap(a, b, 0.5, 0.02), back = overlap(b, a, 0.5, 0.02);
  EXPECT_EQ(there, back);
  return there;
}

TEST(Overlap, KnowsNeighboursFromLayers) {
  const Facet base = facet({0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {0, 1, 2});
  // Over the shared edge 0-1: on the other side, on the same side, and upright.
  EXPECT_FALSE(meet(base, facet({2, 0, 0}, {0, 0, 0}, {1, -2, 0}, {1, 0, 3})));
  EXPECT_TRUE(meet(base, facet({2, 0, 0}, {0, 0, 0}, {1, 1, 0.1}, {1, 0, 3})));
  EXPECT_FALSE(meet(base, facet({2, 0, 0}, {0, 0, 0}, {1, 0.1, 2}, {1, 0, 3})));
  // At the shared corner 0: beside it, and across.
  EXPECT_FALSE(meet(base, facet({0, 0, 0}, {-2, 0, 0}, {0, -2, 0}, {0, 3, 4})));
  EXPECT_TRUE(meet(base, facet({0, 0, 0}, {1, 0.5, -0.1}, {0.5, 1, 0.1}, {0, 3, 4})));
  // No corner shared: a layer close by, a layer far off, a blade through it, and elsewhere.
  EXPECT_TRUE(meet(base, facet({0, 0, 0.3}, {2, 0, 0.3}, {0, 2, 0.3}, {3, 4, 5})));
  EXPECT_FALSE(meet(base, facet({0, 0, 0.7}, {2, 0, 0.7}, {0, 2, 0.7}, {3, 4, 5})));
  EXPECT_TRUE(meet(base, facet({0.5, 0.5, -3}, {0.5, 0.5, 3}, {-5, 5, 3}, {3, 4, 5})));
  EXPECT_FALSE(meet(base, facet({5, 0, 0}, {7, 0, 0}, {5, 2, 0}, {3, 4, 5})));
}

/// A bow tie: two fans of one and two triangles meet in vertex 0.
TEST(Surface, KeepsTheLargestFan) {
  const std::vector<Vec3> points{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}, {1, -1, 0}};
  Surface surface(points);
  const auto add = [&](Triangle t) { surface.add(t, surface.make_facet(t), 0); };
  add({0, 2, 3});
  add({0, 4, 5});
  add({0, 5, 1});
  EXPECT_FALSE(surface.has_room({4, 5, 2}));
  EXPECT_TRUE(surface.has_room({2, 0, 1}));
  std::uint32_t u = 9, w = 9;
  EXPECT_FALSE(surface.single_gap(0, u, w));
  EXPECT_TRUE(surface.single_gap(5, u, w));
  EXPECT_EQ(u, 4u);
  EXPECT_EQ(w, 1u);
  surface.remove_lesser_fans();
  EXPECT_FALSE(surface.alive(0));
  EXPECT_TRUE(surface.alive(1) && surface.alive(2));
  EXPECT_TRUE(surface.around(3).empty());
}

}  // namespace
}  // namespace scanmill::front
