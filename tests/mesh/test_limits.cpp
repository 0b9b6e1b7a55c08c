// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "base/random.hpp"
#include "mesh/limits.hpp"

namespace scanmill {
namespace {

constexpr double kDegree = 0.017453292519943295;

TEST(CosOfDegrees, IsTheCosine) {
  for (double x = -720; x <= 720; x += 0.013)
    ASSERT_NEAR(cos_of_degrees(x),
                static_cast<double>(std::cos(static_cast<long double>(x) * 0.01745329251994329576923690768488612L)),
                1e-15)
        << x;
}

TEST(CosOfDegrees, IsOneAndMinusOneExactly) {
  EXPECT_EQ(cos_of_degrees(0), 1);
  EXPECT_EQ(cos_of_degrees(360), 1);
  EXPECT_EQ(cos_of_degrees(180), -1);
  EXPECT_NEAR(cos_of_degrees(60), 0.5, 1.2e-16);
  EXPECT_NEAR(cos_of_degrees(90), 0, 1e-16);
}

TEST(WithinRange, ComparesTheLongestEdge) {
  const Vec3 a{0, 0, 0}, b{3, 0, 0}, c{0, 4, 0};  // edges 3, 4, 5
  EXPECT_TRUE(within_range(a, b, c, 5));
  EXPECT_FALSE(within_range(a, b, c, 4.999999));
  for (const auto& t : {std::array{b, c, a}, std::array{c, a, b}, std::array{c, b, a}})
    EXPECT_FALSE(within_range(t[0], t[1], t[2], 4.9));
}

TEST(AnglesAtLeast, EqualsAnglesByArcTangent) {
  Random random(1, 1, 1);
  for (int n = 0; n < 20000; ++n) {
    Vec3 p[3];
    for (Vec3& v : p) v = {random.uniform(), random.uniform(), random.uniform()};
    double least = 180;
    for (int k = 0; k < 3; ++k) {
      const Vec3 u = p[(k + 1) % 3] - p[k], v = p[(k + 2) % 3] - p[k];
      least = std::min(least, std::atan2(norm(cross(u, v)), dot(u, v)) / kDegree);
    }
    const double limit = random.uniform(0, 60);
    if (std::abs(least - limit) < 1e-9) continue;
    ASSERT_EQ(angles_at_least(p[0], p[1], p[2], cos_of_degrees(limit)), least >= limit) << least << " and " << limit;
  }
}

TEST(AnglesAtLeast, RefusesTrianglesWithoutArea) {
  const double cosine = cos_of_degrees(1);
  EXPECT_FALSE(angles_at_least({0, 0, 0}, {1, 0, 0}, {2, 0, 0}, cosine));  // on a line
  EXPECT_FALSE(angles_at_least({0, 0, 0}, {0, 0, 0}, {2, 0, 0}, cosine));  // two corners coincide
  EXPECT_TRUE(angles_at_least({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, cos_of_degrees(44.999)));
  EXPECT_FALSE(angles_at_least({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, cos_of_degrees(45.001)));
}

TEST(GrowthLimits, AngleWinsOverCosine) {
  GrowthLimits limits;
  limits.min_normal_dot = 0.25;
  EXPECT_EQ(limits.normal_dot(), 0.25);
  limits.max_normal_deg = 60;
  EXPECT_NEAR(limits.normal_dot(), 0.5, 1e-15);
}

TEST(NormalsAgree, HoldsAtItsLimit) {
  EXPECT_TRUE(normals_agree({0, 0, 1}, {1, 0, 0}, 0));
  EXPECT_FALSE(normals_agree({0, 0, 1}, {0, 0, -1}, 0));
}

}  // namespace
}  // namespace scanmill
