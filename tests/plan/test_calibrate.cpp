// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "base/random.hpp"
#include "plan/calibrate.hpp"

namespace scanmill::plan {
namespace {

/// A cap of a sphere of 20 mm as the sensor sees it, on a floor that holds as many points, with strays.
std::vector<Vec3> ball_on_floor(double noise) {
  Random random(4, 0, 0);
  std::vector<Vec3> points;
  for (int i = 0; i < 6000; ++i) {
    const double x = random.uniform(-25, 25), y = random.uniform(-25, 25), r2 = 400 - x * x - y * y;
    const double z = r2 > 100 ? 170 - std::sqrt(r2) : 164;
    points.push_back({x, y, z + noise * random.gauss() + (i % 40 == 0 ? random.uniform(-8, 8) : 0)});
  }
  return points;
}

TEST(FindTarget, TakesTheSphereOutOfWhatIsAroundIt) {
  const std::vector<Vec3> points = ball_on_floor(0.02);
  for (const std::optional<double> radius : {std::optional<double>(20), std::optional<double>()}) {
    const auto fit = find_target(points, TargetKind::Sphere, radius, 0.02, 1);
    ASSERT_TRUE(fit);
    // Where the floor meets the ball's continuation some of its points count as the ball's.
    EXPECT_LT(norm(fit->centre - Vec3{0, 0, 170}), 0.03);
    EXPECT_NEAR(fit->radius, 20, 0.03);
    EXPECT_NEAR(fit->rms_mm, 0.02, 0.004);
  }
  EXPECT_FALSE(find_target(points, TargetKind::Sphere, 9.0, 0.02, 1));
}

TEST(FindTarget, TakesThePlaneAndTurnsItToTheSensor) {
  const auto fit = find_target(ball_on_floor(0.02), TargetKind::Plane, {}, 0.02, 1);
  ASSERT_TRUE(fit);
  EXPECT_NEAR(fit->centre.z, 164, 0.005);
  EXPECT_LT(norm(fit->normal - Vec3{0, 0, -1}), 1e-3);
}

TEST(FindTarget, FindsNothingInAFewPointsOrAFog) {
  Random random(1, 0, 0);
  std::vector<Vec3> fog;
  for (int i = 0; i < 3000; ++i) fog.push_back({random.uniform(0, 50), random.uniform(0, 50), random.uniform(0, 50)});
  EXPECT_FALSE(find_target(fog, TargetKind::Plane, {}, 0.02, 1));
  fog.resize(50);
  EXPECT_FALSE(find_target(fog, TargetKind::Plane, {}, 0.02, 1));
}

TEST(Calibrate, WantsSixStationsAndRotaryAxes) {
  Machine machine;
  Joint pan;
  pan.name = "a";
  pan.type = JointType::Rotary;
  machine.joints = {pan, Joint{}};
  machine.joints[1].name = "x";
  std::vector<TargetView> views(5, TargetView{"s", {0, 0}, ball_on_floor(0.02)});
  const auto few = calibrate(machine, {}, views, {});
  ASSERT_FALSE(few.ok());
  EXPECT_NE(few.error().message.find("found in 5 of 5 views, wanted at least 6"), std::string::npos);
  CalibrateParams params;
  params.axes = {1};
  EXPECT_NE(calibrate(machine, {}, views, params).error().message.find("joint x is linear"), std::string::npos);
  EXPECT_NE(calibrate({}, {}, views, {}).error().message.find("no joints"), std::string::npos);
}

TEST(Calibrate, LeavesAsPlannedWhatStandingStillCannotTell) {
  // Six views from one and the same place: nothing of the mount can be told from the place of the ball.
  Machine machine;
  machine.joints = {Joint{}};
  machine.joints[0].name = "x";
  const std::vector<TargetView> views(6, TargetView{"s", {0}, ball_on_floor(0.02)});
  const auto found = calibrate(machine, {}, views, {});
  ASSERT_TRUE(found.ok());
  for (const Unknown& unknown : found->unknowns) EXPECT_FALSE(unknown.is_determined) << unknown.name;
  EXPECT_LT(gap_between(found->mount.whole(), Pose{}).mm, 1e-12);
}

}  // namespace
}  // namespace scanmill::plan
