// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "base/random.hpp"
#include "geom/angles.hpp"
#include "geom/pose.hpp"

namespace scanmill {
namespace {

TEST(SineCosineOf, AgreesWithTheLibraryEverywhere) {
  double worst = 0;
  for (int n = -720000; n <= 720000; n += 7) {
    const double degrees = n / 1000.0;
    const auto [s, c] = sine_cosine_of(degrees);
    const long double radians = static_cast<long double>(degrees) * 3.14159265358979323846264338L / 180;
    worst = std::max({worst, std::abs(s - static_cast<double>(std::sin(radians))),
                      std::abs(c - static_cast<double>(std::cos(radians)))});
  }
  EXPECT_LT(worst, 3e-16);
}

TEST(SineCosineOf, IsExactAtQuartersAndKeepsWholeTurns) {
  for (int turns = -3; turns <= 3; ++turns) {
    const double base = 360.0 * turns;
    EXPECT_EQ(sine_cosine_of(base).sine, 0);
    EXPECT_EQ(sine_cosine_of(base).cosine, 1);
    EXPECT_EQ(sine_cosine_of(base + 90).sine, 1);
    EXPECT_EQ(sine_cosine_of(base + 90).cosine, 0);
    EXPECT_EQ(sine_cosine_of(base + 180).cosine, -1);
    EXPECT_EQ(sine_cosine_of(base - 90).sine, -1);
    EXPECT_EQ(sine_cosine_of(base + 12.5).sine, sine_cosine_of(12.5).sine);
    EXPECT_FALSE(std::signbit(sine_cosine_of(base + 90).cosine) && sine_cosine_of(base + 90).cosine == 0);
  }
}

TEST(PoseTurned, TurnsByTheRightHandRuleAboutAnyAxis) {
  EXPECT_EQ(pose_turned({0, 0, 1}, 90).apply({1, 0, 0}), (Vec3{0, 1, 0}));
  EXPECT_EQ(pose_turned({2, 0, 0}, 90).apply({0, 1, 0}), (Vec3{0, 0, 1}));
  EXPECT_EQ(pose_turned({0, -1, 0}, -90).apply({1, 0, 0}), (Vec3{0, 0, -1}));
  const Pose third = pose_turned({1, 1, 1}, 120);
  EXPECT_NEAR(norm(third.apply({1, 0, 0}) - Vec3{0, 1, 0}), 0, 1e-15);
}

TEST(PoseFromAngles, TurnsAboutFixedXThenYThenZ) {
  const Vec3 p{1, 2, 3};
  const Vec3 by_steps =
      pose_turned({0, 0, 1}, 30).apply(pose_turned({0, 1, 0}, 20).apply(pose_turned({1, 0, 0}, 10).apply(p)));
  EXPECT_NEAR(norm(pose_from_angles({10, 20, 30}, {5, 6, 7}).apply(p) - (by_steps + Vec3{5, 6, 7})), 0, 1e-14);
}

TEST(QuaternionOf, IsTheOneThePoseWasMadeFrom) {
  for (std::uint64_t i = 0; i < 2000; ++i) {
    Random random(9, i, 3);
    std::array<double, 4> q{random.gauss(), random.gauss(), random.gauss(), random.gauss()};
    if (i % 4 == 0) q[3] = 1e-9 * random.gauss();  // half turns, where w vanishes
    const Pose pose = *pose_from_quaternion(q[0], q[1], q[2], q[3], {});
    const auto back = quaternion_of(pose);
    EXPECT_GE(back[3], 0);
    const Pose again = *pose_from_quaternion(back[0], back[1], back[2], back[3], {});
    for (std::size_t k = 0; k < 9; ++k) EXPECT_NEAR(again.rotation[k], pose.rotation[k], 4e-15) << i;
  }
}

TEST(GapBetween, MeasuresShiftAndTurn) {
  const Pose a = pose_from_angles({10, -40, 70}, {1, 2, 3});
  for (const double turn : {0.0, 1e-6, 0.5, 89.0, 179.5}) {
    Pose b = a.after(pose_turned({3, -1, 2}, turn));
    b.translation = a.translation + Vec3{0, 3, 4};
    EXPECT_NEAR(gap_between(a, b).degrees, turn, 1e-9);
    EXPECT_DOUBLE_EQ(gap_between(a, b).mm, 5);
  }
}

}  // namespace
}  // namespace scanmill
