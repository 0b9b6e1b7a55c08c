// SPDX-License-Identifier: Apache-2.0
// The loops over arrays, against the same rules one neighbour after the other.
#include <gtest/gtest.h>

#include "base/random.hpp"
#include "stars/tangent.hpp"

namespace scanmill::stars {
namespace {

/// The rule in words: of those that turn, the first with the least parameter; a circle too wide is a gap.
int next_one_by_one(const Tangent& near, int a, double sign, double radius2) {
  const double aa = near.x[a] * near.x[a] + near.y[a] * near.y[a], f = near.power[a] / (2 * aa);
  double best = 1e300;
  int found = -1;
  for (int b = 0; b < near.size; ++b) {
    const double turn = sign * (near.x[a] * near.y[b] - near.y[a] * near.x[b]);
    if (turn <= 1e-9 * aa) continue;
    const double t = (near.power[b] / 2 - f * (near.x[a] * near.x[b] + near.y[a] * near.y[b])) / turn;
    if (t < best) {
      best = t;
      found = b;
    }
  }
  return found >= 0 && (f * f + best * best) * aa > radius2 ? -1 : found;
}

TEST(Tangent, NextIsTheOneThatAskingAllFinds) {
  Random random(4, 0, 0);
  std::size_t gaps = 0, found = 0;
  for (int round = 0; round < 300; ++round) {
    Tangent near{};
    for (int k = 0; k < kMostNear; ++k) near.x[k] = near.y[k] = near.power[k] = -7;  // of an earlier point
    near.size = 1 + static_cast<int>(random.next() % 124);
    for (int k = 0; k < near.size; ++k) {
      const bool on_grid = round % 2 == 0;  // many equal parameters
      near.x[k] = on_grid ? static_cast<double>(random.next() % 5) - 2 : random.uniform(-2.5, 2.5);
      near.y[k] = on_grid ? static_cast<double>(random.next() % 5) - 2 : random.uniform(-2.5, 2.5);
      if (near.x[k] == 0 && near.y[k] == 0) near.x[k] = 1;
      near.power[k] = near.x[k] * near.x[k] + near.y[k] * near.y[k];
    }
    near.pad();
    for (int a = 0; a < near.size; ++a)
      for (const double sign : {1.0, -1.0}) {
        const int next = near.next(a, sign, 2.56);
        ASSERT_EQ(next, next_one_by_one(near, a, sign, 2.56)) << "round " << round << " of " << a;
        ++(next < 0 ? gaps : found);
      }
  }
  EXPECT_GT(gaps, 100u);
  EXPECT_GT(found, 100u);
}

TEST(Tangent, LooksFromThePointAlongItsNormal) {
  Random random(6, 0, 0);
  Near near{};
  const Vec3 n = unit({0.3, -0.2, 1}), e1 = perpendicular(n), e2 = cross(n, e1);
  const View view{{10, 20, 30}, n, e1, e2, 1 / 0.7, 6.25, 0.0004};
  near.size = 77;
  std::vector<Vec3> at, normal;
  for (int k = 0; k < near.size; ++k) {
    at.push_back(view.at + Vec3{random.uniform(-2, 2), random.uniform(-2, 2), random.uniform(-1, 1)});
    normal.push_back(unit({random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)}));
    near.x[k] = at.back().x, near.y[k] = at.back().y, near.z[k] = at.back().z;
    near.nx[k] = normal.back().x, near.ny[k] = normal.back().y, near.nz[k] = normal.back().z;
    near.sure[k] = k % 2;
    near.weight[k] = 1e-3 * random.uniform();
  }
  Seen seen;
  look(near, view, seen);
  int belonging = 0;
  for (int k = 0; k < near.size; ++k) {
    const double agreement = dot(normal[static_cast<std::size_t>(k)], n);
    const Vec3 d = (at[static_cast<std::size_t>(k)] - view.at) * view.scale;
    const double d2 = norm2(d), along = dot(d, n);
    const bool belongs = (k % 2 ? agreement : std::abs(agreement)) >= 0.3 && d2 <= 6.25 && along * along <= 0.64 * d2;
    ASSERT_EQ(seen.belongs[k] > 0, belongs) << k;
    belonging += belongs;
    EXPECT_EQ(seen.power[k], d2 + view.weight - near.weight[k]);
    EXPECT_NEAR(seen.x[k] * seen.x[k] + seen.y[k] * seen.y[k], d2, 1e-12);  // the true distance
    EXPECT_NEAR(seen.x[k] * dot(d, e2), seen.y[k] * dot(d, e1), 1e-12);     // the direction on the plane
  }
  EXPECT_GT(belonging, 5);
  EXPECT_LT(belonging, 70);
}

}  // namespace
}  // namespace scanmill::stars
