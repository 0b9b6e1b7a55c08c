// SPDX-License-Identifier: Apache-2.0
// The demo plans at a quarter of their pixels a side; tests/demo_archive has them at full size.
#include <gtest/gtest.h>

#include "simulate/demo_plans.hpp"

namespace scanmill::simulate {
namespace {

class DemoPlans : public testing::TestWithParam<std::string> {};

TEST_P(DemoPlans, LeaveNoSeenPartOfTheSurfaceOut) {
  const auto object = make_object(GetParam());
  ASSERT_TRUE(object.ok());
  const ChunkLoop loop(2);
  const CancelFlag cancel;
  DemoPlan plan = demo_plan(GetParam());
  EXPECT_EQ(plan.sensor.pixels_x, 700);
  EXPECT_EQ(plan.sensor.pixels_y, 500);
  plan.sensor.pixels_x /= 4;
  plan.sensor.pixels_y /= 4;
  const auto points = measured_points(**object, plan, {loop, cancel});
  const auto nearest = nearest_distances(seen_samples(**object, 20000, 5), points, (*object)->bounds(), 1.0);
  EXPECT_LE(*std::max_element(nearest.begin(), nearest.end()), 0.8);
}

TEST(HandsetPlan, NeverLooksFromBelow) {
  for (const Pose& pose : demo_plan("handset").poses) EXPECT_GT(pose.translation.z, 40);
}

TEST(FigurinePlan, LooksFromBelowToo) {
  int below = 0;
  for (const Pose& pose : demo_plan("figurine").poses) below += pose.translation.z < -50;
  EXPECT_GE(below, 2);
}

INSTANTIATE_TEST_SUITE_P(Plans, DemoPlans, testing::Values("figurine", "handset"),
                         [](const auto& test) { return test.param; });

}  // namespace
}  // namespace scanmill::simulate
