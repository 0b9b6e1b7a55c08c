// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "base/random.hpp"
#include "geom/pose.hpp"

namespace scanmill {
namespace {

void expect_near(Vec3 a, Vec3 b, double tolerance = 1e-12) { EXPECT_LT(norm(a - b), tolerance); }

Pose random_pose(Random& random) {
  auto pose = pose_from_quaternion(random.gauss(), random.gauss(), random.gauss(), random.gauss(),
                                   {random.gauss(), random.gauss(), random.gauss()});
  EXPECT_TRUE(pose.ok());
  return *pose;
}

TEST(Pose, QuaternionTurnsTheUsualWay) {
  const double s = std::sqrt(0.5);
  const auto about_z = pose_from_quaternion(0, 0, s, s, {1, 2, 3});  // a quarter turn about z
  ASSERT_TRUE(about_z.ok());
  expect_near(about_z->apply({1, 0, 0}), {1, 3, 3});
  expect_near(about_z->turn({0, 1, 0}), {-1, 0, 0});
  const auto about_x = pose_from_quaternion(2 * s, 0, 0, 2 * s, {});  // normalised here
  ASSERT_TRUE(about_x.ok());
  expect_near(about_x->apply({0, 1, 0}), {0, 0, 1});
}

TEST(Pose, RefusesQuaternionsThatAreNoRotation) {
  EXPECT_FALSE(pose_from_quaternion(0, 0, 0, 0, {}).ok());
  EXPECT_FALSE(pose_from_quaternion(0, NAN, 0, 1, {}).ok());
  EXPECT_FALSE(pose_from_quaternion(0, 0, 0, 1, {0, INFINITY, 0}).ok());
}

TEST(Pose, InverseAndProductUndoEachOther) {
  Random random(1, 1, 1);
  for (int n = 0; n < 200; ++n) {
    const Pose a = random_pose(random), b = random_pose(random);
    const Vec3 p{random.gauss(), random.gauss(), random.gauss()};
    expect_near(a.inverse().apply(a.apply(p)), p);
    expect_near(a.after(b).apply(p), a.apply(b.apply(p)));
    expect_near(a.after(a.inverse()).apply(p), p);
    expect_near(cross(a.turn({1, 0, 0}), a.turn({0, 1, 0})), a.turn({0, 0, 1}));
  }
}

TEST(Pose, MatrixAndBackIsTheSamePose) {
  Random random(2, 1, 1);
  for (int n = 0; n < 200; ++n) {
    const Pose pose = random_pose(random);
    const auto back = pose_from_matrix(pose.matrix());
    ASSERT_TRUE(back.ok());
    for (std::size_t i = 0; i < 9; ++i) EXPECT_NEAR(back->rotation[i], pose.rotation[i], 1e-15);
    EXPECT_EQ(back->translation, pose.translation);
    const auto again = pose_from_matrix(back->matrix());
    ASSERT_TRUE(again.ok());
    for (std::size_t i = 0; i < 9; ++i) EXPECT_NEAR(again->rotation[i], back->rotation[i], 1e-15);
  }
}

TEST(Pose, MatrixMayBeAThousandthOffButNoMore) {
  std::array<double, 16> m{1, 0, 0, 1, 0, 1, 0, 2, 0, 0, 1, 3, 0, 0, 0, 1};
  m[1] = 5e-4;
  const auto pose = pose_from_matrix(m);
  ASSERT_TRUE(pose.ok());
  const Vec3 x = pose->turn({1, 0, 0}), y = pose->turn({0, 1, 0}), z = pose->turn({0, 0, 1});
  EXPECT_NEAR(dot(x, y), 0, 1e-15);
  expect_near(cross(x, y), z, 1e-15);
  m[1] = 5e-3;
  ASSERT_FALSE(pose_from_matrix(m).ok());
  EXPECT_NE(pose_from_matrix(m).error().message.find("off orthonormal"), std::string::npos);
}

TEST(Pose, RefusesMatricesThatAreNoPose) {
  const std::array<double, 16> unity = Pose{}.matrix();
  auto refused = [&](std::size_t at, double value, const char* words) {
    auto m = unity;
    m[at] = value;
    const auto pose = pose_from_matrix(m);
    return !pose.ok() && pose.error().code == Code::BadInput && pose.error().message.find(words) != std::string::npos;
  };
  EXPECT_TRUE(refused(0, -1, "mirrors"));
  EXPECT_TRUE(refused(0, 2, "off orthonormal"));
  EXPECT_TRUE(refused(12, 5, "transposed"));
  EXPECT_TRUE(refused(15, 2, "last row"));
  EXPECT_TRUE(refused(3, NAN, "not finite"));
}

TEST(Pose, LooksAtItsTargetWithLevelX) {
  Random random(3, 1, 1);
  for (int n = 0; n < 200; ++n) {
    const Vec3 eye{random.gauss(), random.gauss(), random.gauss()},
        target{random.gauss(), random.gauss(), random.gauss()};
    const Vec3 up{0, 0, 1};
    const Pose pose = pose_looking_at(eye, target, up);
    expect_near(pose.apply({0, 0, 0}), eye);
    expect_near(pose.apply({0, 0, norm(target - eye)}), target);
    EXPECT_NEAR(dot(pose.turn({1, 0, 0}), up), 0, 1e-12);
    expect_near(cross(pose.turn({1, 0, 0}), pose.turn({0, 1, 0})), pose.turn({0, 0, 1}));
  }
}

TEST(Pose, LooksStraightDownToo) {
  const Pose pose = pose_looking_at({0, 0, 5}, {0, 0, 0}, {0, 0, 1});
  expect_near(pose.turn({0, 0, 1}), {0, 0, -1});
  EXPECT_NEAR(norm(pose.turn({1, 0, 0})), 1, 1e-15);
  expect_near(cross(pose.turn({1, 0, 0}), pose.turn({0, 1, 0})), {0, 0, -1});
}

}  // namespace
}  // namespace scanmill
