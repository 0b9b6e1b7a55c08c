// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cstring>
#include <memory>

#include "base/random.hpp"
#include "reduce/placing.hpp"

namespace scanmill::reduce {
namespace {

std::vector<Vec3> points_around(std::size_t count, std::uint64_t seed) {
  Random random(seed, 1, 1);
  std::vector<Vec3> points;
  for (std::size_t n = 0; n < count; ++n) points.push_back({random.gauss() * 40, random.gauss() * 40, random.gauss()});
  for (std::size_t n = 0; n + 1 < count; n += 7) points[n + 1] = points[n] + Vec3{0.001, 0, 0};
  if (count > 3) points[2] = {3, -6, 0.75};  // on bin planes
  return points;
}

const Lattice kLattice{0.375, {0.1, -0.2, 0}};
const BinKey kBase{-1024, 0, 0};

// Wider vector instructions, where the processor has them, must not change a bit.
TEST(Placing, IsTheSameInEveryVectorWidth) {
  for (const std::size_t count : {1u, 2u, 7u, 64u, 255u, 256u}) {
    const auto points = points_around(count, count);
    const auto wide = std::make_unique<Placed>(), plain = std::make_unique<Placed>();
    place(kLattice, kBase, points, *wide);
    place_plain(kLattice, kBase, points, *plain);
    ASSERT_EQ(wide->runs, plain->runs);
    ASSERT_EQ(std::memcmp(wide->score.data(), plain->score.data(), count * sizeof(double)), 0);
    ASSERT_EQ(std::memcmp(wide->steps.data(), plain->steps.data(), 2 * count * sizeof(std::uint32_t)), 0);
    for (std::size_t run = 0; run < wide->runs; ++run) {
      ASSERT_EQ(wide->first[run], plain->first[run]);
      ASSERT_EQ(wide->bins[run], plain->bins[run]);
    }
  }
}

TEST(Placing, FollowsThePlainFormulas) {
  const auto points = points_around(256, 5);
  const auto placed = std::make_unique<Placed>();
  place(kLattice, kBase, points, *placed);
  std::size_t run = 0;
  WholeSums sums;
  for (std::size_t n = 0; n < points.size(); ++n) {
    while (placed->first[run + 1] <= n) ++run;
    const BinKey key = bin_of(kLattice, points[n]);
    EXPECT_EQ((BinKey{kBase.i + placed->bins[run][0], kBase.j + placed->bins[run][1], kBase.k + placed->bins[run][2]}),
              key);
    const double u[3] = {(points[n].x - kLattice.origin.x) / kLattice.edge_mm - static_cast<double>(key.i) - 0.5,
                         (points[n].y - kLattice.origin.y) / kLattice.edge_mm - static_cast<double>(key.j) - 0.5,
                         (points[n].z - kLattice.origin.z) / kLattice.edge_mm - static_cast<double>(key.k) - 0.5};
    EXPECT_EQ(placed->score[n], u[0] * u[0] + u[1] * u[1] + u[2] * u[2]);
    double s[3];
    for (int k = 0; k < 3; ++k) s[k] = std::floor(u[k] * 1024 + 0.5);
    WholeSums one;
    one.add(*placed, n, 1);
    EXPECT_EQ(one.count, 1);
    EXPECT_EQ(one.x, s[0]);
    EXPECT_EQ(one.y, s[1]);
    EXPECT_EQ(one.z, s[2]);
    EXPECT_EQ(one.xx, s[0] * s[0]);
    EXPECT_EQ(one.xy, s[0] * s[1]);
    EXPECT_EQ(one.xz, s[0] * s[2]);
    EXPECT_EQ(one.yy, s[1] * s[1]);
    EXPECT_EQ(one.yz, s[1] * s[2]);
    EXPECT_EQ(one.zz, s[2] * s[2]);
    sums.add(one);
  }
  for (const std::size_t end : {255u, 256u}) {  // odd and even runs add up the same
    WholeSums whole;
    whole.add(*placed, 0, end);
    if (end < 256) {
      whole.add(*placed, end, 256 - end);
    }
    EXPECT_EQ(whole.xx, sums.xx);
    EXPECT_EQ(whole.yz, sums.yz);
    EXPECT_EQ(whole.z, sums.z);
    EXPECT_EQ(whole.count, sums.count);
  }
  EXPECT_EQ(placed->first[placed->runs], points.size());
}

}  // namespace
}  // namespace scanmill::reduce
