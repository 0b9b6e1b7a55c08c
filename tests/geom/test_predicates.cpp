// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/random.hpp"
#include "exact.hpp"
#include "geom/predicates.hpp"

namespace scanmill {
namespace {

using exact::Point;

Point random_point(Random& random, std::uint64_t range) {
  auto number = [&] {
    return static_cast<exact::Int>(random.next() % (2 * range + 1)) - static_cast<exact::Int>(range);
  };
  const exact::Int x = number(), y = number(), z = number();
  return {x, y, z};
}

std::vector<Point> random_points(Random& random, std::size_t count, std::uint64_t range) {
  std::vector<Point> points(count);
  for (Point& p : points) p = random_point(random, range);
  return points;
}

/// The next or previous double, some steps away.
double nudged(double x, int steps) {
  for (; steps > 0; --steps) x = std::nextafter(x, INFINITY);
  for (; steps < 0; ++steps) x = std::nextafter(x, -INFINITY);
  return x;
}

std::string text(std::span<const Point> points) {
  std::string out;
  for (const Point& p : points)
    out += "(" + std::to_string(static_cast<long>(p.x)) + " " + std::to_string(static_cast<long>(p.y)) + " " +
           std::to_string(static_cast<long>(p.z)) + ") ";
  return out;
}

// ---- orientation ----

TEST(Orientation, IsPositiveOnTheSideOfTheNormal) {
  const Vec3 a{0, 0, 0}, b{1, 0, 0}, c{0, 1, 0};
  EXPECT_EQ(orientation(a, b, c, {0, 0, 1}), 1);
  EXPECT_EQ(orientation(a, b, c, {0, 0, -1}), -1);
  EXPECT_EQ(orientation(a, b, c, {5, 7, 0}), 0);
}

TEST(Orientation, EqualsIntegerArithmetic) {
  Random random(1, 1, 1);
  int zeros = 0;
  for (const std::uint64_t range : {1, 2, 5, 1000, 1 << 24})
    for (int n = 0; n < 20000; ++n) {
      const auto p = random_points(random, 4, range);
      const int expected = exact::orientation(p[0], p[1], p[2], p[3]);
      zeros += expected == 0;
      ASSERT_EQ(orientation(to_vec3(p[0]), to_vec3(p[1]), to_vec3(p[2]), to_vec3(p[3])), expected) << text(p);
    }
  EXPECT_GT(zeros, 5000);
}

/// Points of one plane with large coordinates, one moved by single units: far below what plain doubles resolve.
TEST(Orientation, EqualsIntegerArithmeticBesideAPlane) {
  Random random(2, 1, 1);
  for (int n = 0; n < 20000; ++n) {
    auto p = random_points(random, 3, 1 << 20);
    const auto u = static_cast<exact::Int>(random.next() % 9) - 4, v = static_cast<exact::Int>(random.next() % 9) - 4;
    p.push_back(p[0] + (p[1] - p[0]) * u + (p[2] - p[0]) * v + random_point(random, n % 2));
    ASSERT_EQ(orientation(to_vec3(p[0]), to_vec3(p[1]), to_vec3(p[2]), to_vec3(p[3])),
              exact::orientation(p[0], p[1], p[2], p[3]))
        << text(p);
  }
}

/// One unit in the last place around a common plane: each swap of two points turns the sign, whatever the rounding.
TEST(Orientation, TurnsWithEachSwapOfNearlyFlatPoints) {
  Random random(3, 1, 1);
  int signs[3] = {};
  for (int n = 0; n < 5000; ++n) {
    std::array<Vec3, 4> p;
    for (Vec3& v : p) {
      v.x = random.uniform(0.5, 1);
      v.y = random.uniform(0.5, 1);
      v.z = nudged((v.x + v.y) / 2, static_cast<int>(random.next() % 3) - 1);
    }
    std::array<int, 4> order{0, 1, 2, 3};
    const int first = orientation(p[0], p[1], p[2], p[3]);
    ++signs[first + 1];
    do {
      int inversions = 0;
      for (std::size_t i = 0; i < 4; ++i)
        for (std::size_t j = i + 1; j < 4; ++j) inversions += order[i] > order[j];
      auto at = [&](std::size_t i) { return p[static_cast<std::size_t>(order[i])]; };
      ASSERT_EQ(orientation(at(0), at(1), at(2), at(3)), inversions % 2 ? -first : first);
    } while (std::next_permutation(order.begin(), order.end()));
  }
  EXPECT_GT(std::min({signs[0], signs[1], signs[2]}), 10);
}

TEST(OrientationFlat, EqualsIntegerArithmeticAlongEachAxis) {
  Random random(4, 1, 1);
  for (const std::uint64_t range : {1, 3, 1 << 24})
    for (int n = 0; n < 10000; ++n) {
      const auto p = random_points(random, 3, range);
      const Point area = cross(p[1] - p[0], p[2] - p[0]);
      const exact::Int expected[3] = {area.x, area.y, area.z};
      for (int axis = 0; axis < 3; ++axis)
        ASSERT_EQ(orientation_flat(to_vec3(p[0]), to_vec3(p[1]), to_vec3(p[2]), axis), exact::sign(expected[axis]));
    }
}

TEST(OrientationFlat, TurnsWithEachSwapOfNearlyCollinearPoints) {
  Random random(5, 1, 1);
  int zeros = 0;
  for (int n = 0; n < 20000; ++n) {
    Vec3 p[3];
    for (Vec3& v : p) {
      v.x = random.uniform(0.5, 1);
      v.y = nudged(v.x, static_cast<int>(random.next() % 3) - 1);
    }
    const int s = orientation_flat(p[0], p[1], p[2], 2);
    zeros += s == 0;
    ASSERT_EQ(orientation_flat(p[1], p[2], p[0], 2), s);
    ASSERT_EQ(orientation_flat(p[1], p[0], p[2], 2), -s);
    ASSERT_EQ(orientation_flat(p[0], p[2], p[1], 2), -s);
    ASSERT_EQ(orientation_flat(p[2], p[1], p[0], 2), -s);
  }
  EXPECT_GT(zeros, 100);
}

// ---- segment and triangle ----

/*  c
    |\      the triangle of the next tests, in z = 0
    | \
    a--b   */
constexpr Vec3 kA{0, 0, 0}, kB{4, 0, 0}, kC{0, 4, 0};
bool meets(Vec3 p, Vec3 q) {
  const bool met = segment_meets_triangle(p, q, kA, kB, kC);
  EXPECT_EQ(segment_meets_triangle(q, p, kA, kB, kC), met);
  EXPECT_EQ(segment_meets_triangle(q, p, kB, kA, kC), met);
  EXPECT_EQ(segment_meets_triangle(p, q, kC, kA, kB), met);
  return met;
}

TEST(SegmentMeetsTriangle, CountsTouchingAsMeeting) {
  EXPECT_TRUE(meets({1, 1, -1}, {1, 1, 1}));   // through the inside
  EXPECT_TRUE(meets({1, 1, 0}, {1, 1, 5}));    // stands on it
  EXPECT_TRUE(meets({0, 0, 0}, {0, 0, 5}));    // stands on a corner
  EXPECT_TRUE(meets({2, -1, -1}, {2, 1, 1}));  // through an edge
  EXPECT_TRUE(meets({-1, 0, -1}, {1, 0, 1}));  // through a corner
  EXPECT_FALSE(meets({1, 1, 1}, {1, 1, 5}));   // above
  EXPECT_FALSE(meets({3, 3, -1}, {3, 3, 1}));  // beside
  EXPECT_FALSE(meets({5, 0, -1}, {5, 0, 1}));  // beside, on an edge's line
}

TEST(SegmentMeetsTriangle, DecidesInTheTrianglesOwnPlane) {
  EXPECT_TRUE(meets({1, 1, 0}, {2, 1, 0}));         // inside
  EXPECT_TRUE(meets({-1, 1, 0}, {9, 1, 0}));        // right across
  EXPECT_TRUE(meets({-1, 0, 0}, {9, 0, 0}));        // along an edge, beyond both ends
  EXPECT_TRUE(meets({1, 0, 0}, {2, 0, 0}));         // within an edge
  EXPECT_TRUE(meets({-1, 1, 0}, {1, -1, 0}));       // touches a corner
  EXPECT_TRUE(meets({4, 0, 0}, {9, 0, 0}));         // begins in a corner
  EXPECT_FALSE(meets({5, 0, 0}, {9, 0, 0}));        // on an edge's line, beside
  EXPECT_FALSE(meets({-1, 0.5, 0}, {0.5, -1, 0}));  // passes a corner
  EXPECT_FALSE(meets({3, 3, 0}, {4, 4, 0}));
}

TEST(SegmentMeetsTriangle, EqualsIntegerArithmetic) {
  Random random(6, 1, 1);
  int met = 0, flat = 0;
  for (const std::uint64_t range : {1, 2, 4, 1000})
    for (int n = 0; n < 20000; ++n) {
      auto p = random_points(random, 5, range);
      if (n % 2)  // all in one plane
        for (Point& v : p) v.z = v.x - v.y;
      const std::span<const Point> segment(p.data(), 2), triangle(p.data() + 2, 3);
      if (!exact::has_area(triangle)) continue;
      const bool expected = exact::hulls_meet(segment, triangle);
      met += expected;
      flat += expected && n % 2;
      ASSERT_EQ(segment_meets_triangle(to_vec3(p[0]), to_vec3(p[1]), to_vec3(p[2]), to_vec3(p[3]), to_vec3(p[4])),
                expected)
          << text(p);
    }
  EXPECT_GT(met, 5000);
  EXPECT_GT(flat, 2000);
}

}  // namespace
}  // namespace scanmill
