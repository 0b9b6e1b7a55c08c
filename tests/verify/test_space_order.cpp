// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>

#include "base/random.hpp"
#include "verify/space_order.hpp"

namespace scanmill::verify {
namespace {

double way_along(std::span<const Vec3> points, std::span<const std::uint32_t> rows) {
  double way = 0;
  for (std::size_t n = 1; n < rows.size(); ++n) way += norm(points[rows[n]] - points[rows[n - 1]]);
  return way;
}

TEST(SpaceOrder, BringsNeighboursTogetherAndLosesNone) {
  Random random(1, 1, 1);
  std::vector<Vec3> points;
  for (int n = 0; n < 5000; ++n)
    points.push_back({random.uniform(0, 50), random.uniform(0, 50), 0.1 * random.uniform()});
  SpaceOrder order;
  const auto rows = order.of(points, 0.5);
  std::vector<std::uint32_t> all(rows.begin(), rows.end()), as_given(points.size());
  for (std::uint32_t n = 0; n < as_given.size(); ++n) as_given[n] = n;
  EXPECT_LT(way_along(points, rows), 0.1 * way_along(points, as_given));
  std::sort(all.begin(), all.end());
  EXPECT_EQ(all, as_given);
}

TEST(SpaceOrder, LeavesScanLinesAsTheyAre) {
  std::vector<Vec3> points;
  for (int line = 0; line < 20; ++line)
    for (int n = 0; n < 100; ++n) points.push_back({n * 0.1, line * 0.1, 0});
  SpaceOrder order;
  const auto rows = order.of(points, 0.1);
  for (std::uint32_t n = 0; n < points.size(); ++n) ASSERT_EQ(rows[n], n);
}

TEST(SpaceOrder, TakesPointsInOnePlaceAndPointsWorldsApart) {
  SpaceOrder order;
  EXPECT_TRUE(order.of({}, 1).empty());
  const std::vector<Vec3> far{{-1e15, 0, 0}, {1e15, 1e15, 0}, {-1e15, 0, 1}, {0, 0, 1e15}};
  EXPECT_EQ(order.of(far, 1e-3).size(), 4u);
  const std::vector<Vec3> same(9, Vec3{1, 2, 3});
  EXPECT_EQ(order.of(same, 0).size(), 9u);
}

}  // namespace
}  // namespace scanmill::verify
