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

/// Where a point lies in its bin, in bin edges about the centre.
Vec3 inside_of(Vec3 p, const BinKey& key) {
  return {(p.x - kLattice.origin.x) / kLattice.edge_mm - static_cast<double>(key.i) - 0.5,
          (p.y - kLattice.origin.y) / kLattice.edge_mm - static_cast<double>(key.j) - 0.5,
          (p.z - kLattice.origin.z) / kLattice.edge_mm - static_cast<double>(key.k) - 0.5};
}

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
  for (std::size_t n = 0; n < points.size(); ++n) {
    while (placed->first[run + 1] <= n) ++run;
    const BinKey key = bin_of(kLattice, points[n]);
    EXPECT_EQ((BinKey{kBase.i + placed->bins[run][0], kBase.j + placed->bins[run][1], kBase.k + placed->bins[run][2]}),
              key);
    const Vec3 u = inside_of(points[n], key);
    EXPECT_EQ(placed->score[n], u.x * u.x + u.y * u.y + u.z * u.z);
  }
  EXPECT_EQ(placed->first[placed->runs], points.size());
}

// Runs of one point and of many, and a tile that is not full.
TEST(Placing, SumsAndLeastScoresOfRunsAreThoseOfTheirPoints) {
  const auto placed = std::make_unique<Placed>();
  const auto sums = std::make_unique<RunSums>(), plain = std::make_unique<RunSums>();
  for (const double spread : {1.0, 0.01, 1e-6})
    for (const std::size_t count : {1u, 63u, 64u, 200u, 256u}) {
      auto points = points_around(count, count + 7);
      for (Vec3& p : points) p = p * spread;
      place(kLattice, kBase, points, *placed);
      sum_runs(*placed, *sums);
      sum_runs_plain(*placed, *plain);
      std::uint32_t seen = 0;
      for (std::size_t run = 0; run < placed->runs; ++run) {
        ASSERT_EQ(placed->first[run], seen);
        WholeSums wanted, found;
        double least = 1e300;
        for (; seen < placed->first[run + 1]; ++seen) {
          const Vec3 u = inside_of(points[seen], bin_of(kLattice, points[seen]));
          const double x = std::floor(u.x * 1024 + 0.5), y = std::floor(u.y * 1024 + 0.5),
                       z = std::floor(u.z * 1024 + 0.5);
          wanted.add(WholeSums{x * x, y * y, z * z, 1, x * y, y * z, x * z, z, x, y});
          least = std::min(least, placed->score[seen]);
        }
        found.add(*sums, run);
        EXPECT_EQ(std::memcmp(&found, &wanted, sizeof found), 0) << "run " << run << " of " << count;
        EXPECT_EQ(sums->least(run), least);
        WholeSums narrow;
        narrow.add(*plain, run);
        EXPECT_EQ(std::memcmp(&found, &narrow, sizeof found), 0) << "run " << run << " of " << count;
        EXPECT_EQ(plain->least(run), least);
      }
      EXPECT_EQ(seen, count);
    }
}

}  // namespace
}  // namespace scanmill::reduce
