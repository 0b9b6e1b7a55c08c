// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "base/random.hpp"
#include "exact.hpp"
#include "geom/predicates.hpp"

namespace scanmill {
namespace {

using exact::Point;

/// The answer must not depend on which triangle comes first, nor on the order of corners.
bool cross(const Corners& s, const Corners& t) {
  const bool answer = triangles_cross(s, t);
  static constexpr unsigned kOrders[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {1, 0, 2}, {0, 2, 1}, {2, 1, 0}};
  auto turned = [](const Corners& c, const unsigned* o) {
    return Corners{{c.at[o[0]], c.at[o[1]], c.at[o[2]]}, {c.id[o[0]], c.id[o[1]], c.id[o[2]]}};
  };
  for (const auto& a : kOrders)
    for (const auto& b : kOrders) {
      EXPECT_EQ(triangles_cross(turned(s, a), turned(t, b)), answer);
      EXPECT_EQ(triangles_cross(turned(t, b), turned(s, a)), answer);
    }
  return answer;
}

/*    2
     / \       the first triangle of the drawn cases: 0 (0,0) 1 (4,0) 2 (2,4), z = 0
    0---1   */
const Corners kFirst{{Vec3{0, 0, 0}, Vec3{4, 0, 0}, Vec3{2, 4, 0}}, {0, 1, 2}};

TEST(TrianglesCross, DisjointDoNot) {
  EXPECT_FALSE(cross(kFirst, {{Vec3{0, 0, 1}, Vec3{4, 0, 1}, Vec3{2, 4, 1}}, {3, 4, 5}}));   // a storey above
  EXPECT_FALSE(cross(kFirst, {{Vec3{6, 0, 0}, Vec3{9, 0, 0}, Vec3{7, 4, 0}}, {3, 4, 5}}));   // beside, same plane
  EXPECT_FALSE(cross(kFirst, {{Vec3{5, 1, -1}, Vec3{5, 1, 1}, Vec3{9, 1, 0}}, {3, 4, 5}}));  // upright, beside
}

TEST(TrianglesCross, PiercingAndTouchingDo) {
  EXPECT_TRUE(cross(kFirst, {{Vec3{2, 1, -1}, Vec3{2, 1, 1}, Vec3{9, 1, 0}}, {3, 4, 5}}));  // an edge goes through
  EXPECT_TRUE(cross(kFirst, {{Vec3{2, 1, 0}, Vec3{2, 1, 3}, Vec3{3, 1, 3}}, {3, 4, 5}}));   // stands on a corner
  EXPECT_TRUE(
      cross(kFirst, {{Vec3{4, 0, 0}, Vec3{6, 0, 2}, Vec3{6, 0, -2}}, {3, 4, 5}}));  // corner on corner, other id
  EXPECT_TRUE(cross(kFirst, {{Vec3{1, 0, 0}, Vec3{3, 0, 0}, Vec3{2, -3, 0}}, {3, 4, 5}}));  // edge on edge, other ids
}

TEST(TrianglesCross, OverlapInOnePlaneDoes) {
  EXPECT_TRUE(cross(kFirst, {{Vec3{2, 1, 0}, Vec3{6, 1, 0}, Vec3{4, 5, 0}}, {3, 4, 5}}));        // partly
  EXPECT_TRUE(cross(kFirst, {{Vec3{1.8, 1, 0}, Vec3{2.2, 1, 0}, Vec3{2, 1.2, 0}}, {3, 4, 5}}));  // wholly inside
  EXPECT_TRUE(cross(kFirst, {{Vec3{0, 3, 0}, Vec3{4, 3, 0}, Vec3{2, -1, 0}}, {3, 4, 5}}));       // a star of six points
}

/*  T junction: the corner 5 of the second lies within the edge 0-1 of the first
      2
     / \
    0-5-1
     / \
    3---4   */
TEST(TrianglesCross, TJunctionDoes) {
  EXPECT_TRUE(cross(kFirst, {{Vec3{1, -2, 0}, Vec3{3, -2, 0}, Vec3{2, 0, 0}}, {3, 4, 5}}));
  EXPECT_TRUE(cross(kFirst, {{Vec3{1, -2, 1}, Vec3{3, -2, 1}, Vec3{2, 0, 0}}, {3, 4, 5}}));
}

/*    2
     / \
    0---1---3     a common corner 1
         \ /
          4   */
TEST(TrianglesCross, CommonCornerAloneDoesNot) {
  EXPECT_FALSE(cross(kFirst, {{Vec3{4, 0, 0}, Vec3{8, 0, 0}, Vec3{6, -4, 0}}, {1, 3, 4}}));
  EXPECT_FALSE(cross(kFirst, {{Vec3{4, 0, 0}, Vec3{6, 0, 2}, Vec3{6, 0, -2}}, {1, 3, 4}}));
  EXPECT_FALSE(cross(kFirst, {{Vec3{4, 0, 0}, Vec3{2, 0, 2}, Vec3{2, 4, 2}}, {1, 3, 4}}));  // opens like a book
}

TEST(TrianglesCross, CommonCornerAndMoreDoes) {
  EXPECT_TRUE(
      cross(kFirst, {{Vec3{4, 0, 0}, Vec3{1, 1, 2}, Vec3{1, 1, -2}}, {1, 3, 4}}));         // cuts through from corner 1
  EXPECT_TRUE(cross(kFirst, {{Vec3{4, 0, 0}, Vec3{1, 1, 0}, Vec3{1, 2, 0}}, {1, 3, 4}}));  // overlaps in the plane
  EXPECT_TRUE(cross(kFirst, {{Vec3{4, 0, 0}, Vec3{2, 0, 0}, Vec3{3, -3, 0}}, {1, 3, 4}}));   // lies along the edge 1-0
  EXPECT_TRUE(cross(kFirst, {{Vec3{4, 0, 0}, Vec3{-1, 0, 0}, Vec3{1, -3, 0}}, {1, 3, 4}}));  // covers the edge 1-0
}

/*    2
     / \
    0---1     a common edge 0-1
     \ /
      3   */
TEST(TrianglesCross, CommonEdgeDoesOnlyWhenFoldedFlat) {
  EXPECT_FALSE(cross(kFirst, {{Vec3{4, 0, 0}, Vec3{0, 0, 0}, Vec3{2, -4, 0}}, {1, 0, 3}}));
  EXPECT_FALSE(cross(kFirst, {{Vec3{4, 0, 0}, Vec3{0, 0, 0}, Vec3{2, 4, 1e-12}}, {1, 0, 3}}));  // nearly folded
  EXPECT_TRUE(cross(kFirst, {{Vec3{4, 0, 0}, Vec3{0, 0, 0}, Vec3{2, 4, 0}}, {1, 0, 3}}));       // folded onto itself
  EXPECT_TRUE(cross(kFirst, {{Vec3{4, 0, 0}, Vec3{0, 0, 0}, Vec3{9, 1, 0}}, {1, 0, 3}}));
}

TEST(TrianglesCross, TheSameTriangleTwiceDoes) { EXPECT_TRUE(cross(kFirst, kFirst)); }

TEST(TrianglesCross, WithoutAreaDoNot) {
  EXPECT_FALSE(cross(kFirst, {{Vec3{2, 1, -1}, Vec3{2, 1, 0}, Vec3{2, 1, 5}}, {3, 4, 5}}));
}

/// Integer corners; small ranges give every degenerate case many times.
void compare_with_integers(std::uint64_t seed, std::uint64_t range, int rounds, int shared, bool flat, int counts[2]) {
  Random random(seed, range, static_cast<std::uint64_t>(shared));
  for (int n = 0; n < rounds; ++n) {
    Point p[6];
    for (Point& v : p) {
      v.x = static_cast<exact::Int>(random.next() % (2 * range + 1)) - static_cast<exact::Int>(range);
      v.y = static_cast<exact::Int>(random.next() % (2 * range + 1)) - static_cast<exact::Int>(range);
      v.z =
          flat ? v.x + v.y : static_cast<exact::Int>(random.next() % (2 * range + 1)) - static_cast<exact::Int>(range);
    }
    unsigned id[6] = {0, 1, 2, 3, 4, 5};
    for (int k = 0; k < shared; ++k) {
      p[3 + k] = p[k];
      id[3 + k] = id[k];
    }
    const std::span<const Point> s(p, 3), t(p + 3, 3);
    if (!exact::has_area(s) || !exact::has_area(t)) continue;
    bool expected = false;
    if (shared == 0) expected = exact::hulls_meet(s, t);
    if (shared == 1) {
      // Beyond the common corner: the first's far edge meets the second's cone, cut off where it is wide enough.
      const Point v = p[0];
      const Point wide[3] = {v, v + (p[4] - v) * 4096, v + (p[5] - v) * 4096};
      expected = exact::hulls_meet(s.subspan(1), wide);
    }
    if (shared == 2) {
      const Point m = exact::cross(p[1] - p[0], p[2] - p[0]), o = exact::cross(p[1] - p[0], p[5] - p[0]);
      expected = exact::cross(m, o) == Point{} && exact::dot(m, o) > 0;
    }
    ++counts[expected];
    const Corners a{{to_vec3(p[0]), to_vec3(p[1]), to_vec3(p[2])}, {id[0], id[1], id[2]}};
    const Corners b{{to_vec3(p[3]), to_vec3(p[4]), to_vec3(p[5])}, {id[3], id[4], id[5]}};
    ASSERT_EQ(triangles_cross(a, b), expected) << "seed " << seed << " round " << n << " shared " << shared;
    ASSERT_EQ(triangles_cross(b, a), expected) << "seed " << seed << " round " << n << " shared " << shared;
  }
}

TEST(TrianglesCross, EqualsIntegerArithmetic) {
  for (int shared = 0; shared <= 2; ++shared)
    for (const bool flat : {false, true})
      for (const std::uint64_t range : {1, 2, 4}) {
        int counts[2] = {};
        ASSERT_NO_FATAL_FAILURE(compare_with_integers(77, range, 4000, shared, flat, counts));
        EXPECT_GT(counts[0], 20) << shared << flat;
        if (shared < 2 || flat) {
          EXPECT_GT(counts[1], 20) << shared << flat;
        }
      }
}

}  // namespace
}  // namespace scanmill
