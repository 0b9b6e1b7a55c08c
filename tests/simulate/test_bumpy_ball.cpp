// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/digest.hpp"
#include "simulate/bumpy_ball.hpp"

namespace scanmill::simulate {
namespace {

std::vector<BumpyBall::Point> all_of(const BumpyBall& ball) {
  std::vector<BumpyBall::Point> points(ball.points());
  ball.fill(0, points);
  return points;
}

std::string digest_of(const std::vector<BumpyBall::Point>& points) {
  return sha256_hex({reinterpret_cast<const char*>(points.data()), points.size() * sizeof points[0]});
}

TEST(BumpyBall, HasTheSameBytesEverywhere) {
  EXPECT_EQ(digest_of(all_of(BumpyBall(100'000, 1))),
            "8ff7821341ba23a40636f3a2806959047899802739542e56945b1a3d202acb24");
  EXPECT_NE(digest_of(all_of(BumpyBall(100'000, 2))), digest_of(all_of(BumpyBall(100'000, 1))));
}

TEST(BumpyBall, PiecesInAnyOrderMakeTheWhole) {
  for (const std::uint64_t count : {1ull, 5ull, 26ull, 27ull, 1000ull, 54'321ull}) {
    const BumpyBall ball(count, 7);
    const std::vector<BumpyBall::Point> whole = all_of(ball);
    for (const std::uint64_t piece : {1ull, 77ull, 4096ull}) {
      if (count / piece > 2000) continue;
      std::vector<BumpyBall::Point> pieces(count);
      for (std::uint64_t first = (count - 1) / piece * piece;; first -= piece) {
        ball.fill(first, std::span(pieces).subspan(first, std::min(piece, count - first)));
        if (first == 0) break;
      }
      EXPECT_EQ(pieces, whole) << count << " points in pieces of " << piece;
    }
  }
}

TEST(BumpyBall, ViewsShareAllPoints) {
  for (const std::uint64_t count : {1ull, 30ull, 100'003ull, 1'000'000'000ull, 30'000'000'001ull}) {
    const BumpyBall ball(count, 1);
    EXPECT_EQ(ball.first_of_view(0), 0u);
    EXPECT_EQ(ball.first_of_view(ball.views()), count);
    std::uint64_t least = count, most = 0;
    for (std::size_t v = 0; v < ball.views(); ++v) {
      const std::uint64_t size = ball.first_of_view(v + 1) - ball.first_of_view(v);
      least = std::min(least, size);
      most = std::max(most, size);
    }
    EXPECT_LE(most - least, 1u) << count;
  }
}

TEST(BumpyBall, PointsLieOnTheSurfaceAndAllRoundIt) {
  const BumpyBall ball(200'000, 3);
  const double radius = ball.radius_mm();
  std::uint64_t in_octant[8] = {};
  for (const BumpyBall::Point& p : all_of(ball)) {
    const Vec3 at{p[0], p[1], p[2]};
    for (const double c : {at.x, at.y, at.z}) ASSERT_LE(std::abs(c), ball.reach_mm());
    const Vec3 d = at * (1 / norm(at));
    const auto chebyshev = [](double x) { return std::cos(6 * std::acos(std::clamp(x, -1.0, 1.0))); };
    const double r = radius * (1 + 0.01 * (chebyshev(d.x) + chebyshev(d.y) + chebyshev(d.z)));
    // The noise along the line of sight, at most 3.5 deviations, moves a point off the surface by no more than that.
    ASSERT_NEAR(norm(at), r, 3.6 * BumpyBall::kNoiseMm * 1.1) << at.x << " " << at.y << " " << at.z;
    ++in_octant[(at.x > 0) + 2 * (at.y > 0) + 4 * (at.z > 0)];
  }
  for (const std::uint64_t count : in_octant) EXPECT_NEAR(static_cast<double>(count), 25'000, 2'500);
}

TEST(BumpyBall, NeighboursOfARowFollowAScanLine) {
  const BumpyBall ball(1'000'000, 1);
  const std::vector<BumpyBall::Point> points = all_of(ball);
  const double pitch = 1 / std::sqrt(BumpyBall::kPointsPerMm2 / static_cast<double>(ball.views()) * 2);
  std::uint64_t near = 0;
  for (std::size_t i = 1; i < points.size(); ++i) {
    double square = 0;
    for (int axis = 0; axis < 3; ++axis)
      square += (double{points[i][axis]} - points[i - 1][axis]) * (double{points[i][axis]} - points[i - 1][axis]);
    near += square < 16 * pitch * pitch;
  }
  EXPECT_GT(near, points.size() * 98 / 100);
}

}  // namespace
}  // namespace scanmill::simulate
