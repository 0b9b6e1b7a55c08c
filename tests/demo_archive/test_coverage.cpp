// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <iostream>

#include "simulate/demo_plans.hpp"

namespace scanmill::simulate {
namespace {

class DemoArchive : public testing::TestWithParam<std::string> {};

TEST_P(DemoArchive, MeasuresEveryPartOfTheSurfaceWithinAThirdOfAMillimetre) {
  const auto object = make_object(GetParam());
  ASSERT_TRUE(object.ok());
  const ChunkLoop loop(2);
  const CancelFlag cancel;
  const DemoPlan plan = demo_plan(GetParam());
  const auto points = measured_points(**object, plan, {loop, cancel});
  const auto samples = seen_samples(**object, 200000, 11);
  auto nearest = nearest_distances(samples, points, (*object)->bounds(), 1.0);
  std::sort(nearest.begin(), nearest.end());
  const double p999 = nearest[nearest.size() * 999 / 1000];
  std::cout << GetParam() << ": " << plan.poses.size() << " stations, " << points.size() << " points; "
            << samples.size() << " samples, nearest point at most " << nearest.back() << " mm, p99.9 " << p999
            << " mm\n";
  EXPECT_LE(nearest.back(), 0.35);
  EXPECT_LE(p999, 0.2);
  EXPECT_LE(points.size(), 4'500'000u);
}

INSTANTIATE_TEST_SUITE_P(Plans, DemoArchive, testing::Values("figurine", "handset"),
                         [](const auto& test) { return test.param; });

}  // namespace
}  // namespace scanmill::simulate
