// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "base/random.hpp"
#include "geom/plane_fit.hpp"

namespace scanmill {
namespace {

/// Sum of s_i a_i a_i^T for orthonormal axes a_i.
Covariance from_axes(const Vec3 (&axis)[3], const double (&s)[3]) {
  Covariance c;
  for (int i = 0; i < 3; ++i) {
    const Vec3 a = axis[i];
    c.xx += s[i] * a.x * a.x;
    c.xy += s[i] * a.x * a.y;
    c.xz += s[i] * a.x * a.z;
    c.yy += s[i] * a.y * a.y;
    c.yz += s[i] * a.y * a.z;
    c.zz += s[i] * a.z * a.z;
  }
  return c;
}

void random_axes(Random& random, Vec3 (&axis)[3]) {
  axis[0] = unit({random.gauss(), random.gauss(), random.gauss()});
  axis[1] = unit(cross(axis[0], {random.gauss(), random.gauss(), random.gauss()}));
  axis[2] = cross(axis[0], axis[1]);
}

TEST(FitPlane, FindsTheAxisOfLeastSpread) {
  Random random(1, 1, 1);
  for (int n = 0; n < 5000; ++n) {
    Vec3 axis[3];
    random_axes(random, axis);
    const double scale = n % 3 == 0 ? 1e-6 : n % 3 == 1 ? 1 : 1e6;
    const double s[3] = {random.uniform(0, 0.1) * scale, random.uniform(0.2, 1) * scale,
                         random.uniform(0.2, 1) * scale};
    const PlaneFit fit = fit_plane(from_axes(axis, s));
    ASSERT_NEAR(norm(fit.normal), 1, 1e-15);
    ASSERT_LT(norm(cross(fit.normal, axis[0])), 1e-13);
    ASSERT_NEAR(fit.least, s[0], 1e-14 * scale);
    ASSERT_NEAR(fit.trace, s[0] + s[1] + s[2], 1e-14 * scale);
  }
}

TEST(FitPlane, AgreesWithEigenOnAnySymmetricMatrix) {
  Random random(2, 1, 1);
  for (int n = 0; n < 5000; ++n) {
    Eigen::Matrix3d b;
    for (int i = 0; i < 9; ++i) b(i / 3, i % 3) = random.gauss();
    const Eigen::Matrix3d a = b * b.transpose();
    const PlaneFit fit = fit_plane({a(0, 0), a(0, 1), a(0, 2), a(1, 1), a(1, 2), a(2, 2)});
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(a);
    ASSERT_NEAR(fit.least, std::max(0.0, solver.eigenvalues()[0]), 1e-13 * fit.trace);
    const Eigen::Vector3d normal(fit.normal.x, fit.normal.y, fit.normal.z);
    ASSERT_LT((a * normal - fit.least * normal).norm(), 1e-13 * fit.trace);
  }
}

TEST(FitPlane, MakesTheLargestComponentPositive) {
  Random random(3, 1, 1);
  for (int n = 0; n < 1000; ++n) {
    Vec3 axis[3];
    random_axes(random, axis);
    const Vec3 m = fit_plane(from_axes(axis, {0.01, 1, 2})).normal;
    const double size = std::max({std::abs(m.x), std::abs(m.y), std::abs(m.z)});
    ASSERT_TRUE(m.x == size || m.y == size || m.z == size);
  }
}

TEST(FitPlane, GivesTheZAxisWhereNoDirectionIsBest) {
  for (const double s : {0.0, 1.0, 1e-12, 1e12}) EXPECT_EQ(fit_plane({s, 0, 0, s, 0, s}).normal, (Vec3{0, 0, 1}));
}

TEST(FitPlane, NeverGivesANegativeLeast) {
  // A flat cloud whose moments were rounded: the least eigenvalue is a little below zero.
  EXPECT_EQ(fit_plane({1, 0, 0, 1, 0, -1e-17}).least, 0);
  EXPECT_EQ(fit_plane({1, 0, 0, 1, 0, -1e-17}).normal, (Vec3{0, 0, 1}));
}

}  // namespace
}  // namespace scanmill
