// SPDX-License-Identifier: Apache-2.0
// All crossings at once, against asking every pair.
#include <gtest/gtest.h>

#include <algorithm>
#include <optional>

#include "base/random.hpp"
#include "flat_points.hpp"
#include "stars/crossings.hpp"
#include "support/meshing.hpp"

namespace scanmill::stars {
namespace {

using Pair = std::array<std::uint32_t, 2>;

std::vector<Pair> asked_one_by_one(const Site& site) {
  std::vector<Pair> pairs;
  for (std::uint32_t s = 0; s < site.complex.triangle_count(); ++s)
    for (std::uint32_t t = s + 1; t < site.complex.triangle_count(); ++t)
      if (site.complex.alive(s) && site.complex.alive(t) &&
          triangles_cross(site.corners(site.complex.triangle(s)), site.corners(site.complex.triangle(t))))
        pairs.push_back({s, t});
  return pairs;
}

std::vector<Pair> found_at_once(const Site& site, int threads) {
  const ChunkLoop loop(threads);
  const CancelFlag cancel;
  std::vector<Pair> pairs = crossing_pairs(site, {loop, cancel});
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

HandMade slab(std::uint64_t seed, double thickness) {
  std::vector<Vec3> cloud;
  Random random(seed, 0, 3);
  for (int i = 0; i < 9; ++i)
    for (int j = 0; j < 9; ++j)
      cloud.push_back({i + random.uniform(), j + random.uniform(), thickness * random.uniform()});
  return HandMade(cloud);
}

/// Random triangles, crossing or not, some of them removed again.
TEST(CrossingPairs, AreThoseThatEveryPairSays) {
  std::size_t crossing = 0, apart = 0;
  for (const double thickness : {0.0, 1.0}) {
    const HandMade made = slab(static_cast<std::uint64_t>(7 + thickness), thickness);
    const SurfacePoints points = made.points();
    Site site(points, {}, made.normal);
    Random random(5, 1, 1);
    for (int n = 0; n < 20000; ++n) {
      const auto pick = [&] { return static_cast<std::uint32_t>(random.next() % points.bins.size()); };
      const Triangle t{pick(), pick(), pick()};
      if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0] || !site.within_limits(t) || !site.complex.edges_free(t))
        continue;
      const std::uint32_t number = site.complex.add(t, 3);
      if (n % 5 == 0) site.complex.remove(number);
    }
    const std::vector<Pair> expected = asked_one_by_one(site);
    EXPECT_EQ(found_at_once(site, 1), expected);
    EXPECT_EQ(found_at_once(site, 3), expected);
    crossing += expected.size();
    apart += site.complex.triangle_count();
  }
  EXPECT_GT(crossing, 100u);
  EXPECT_GT(apart, 100u);
}

TEST(CrossingPairs, OfNoTrianglesAreNone) {
  const HandMade made = slab(1, 0);
  const SurfacePoints points = made.points();
  EXPECT_TRUE(found_at_once(Site(points, {}, made.normal), 1).empty());
}

/// A mesh of random heights: no crossings, but many folds as seen from any one side.
TEST(CrossingPairs, AreNoneOnAHeightField) {
  constexpr int kSide = 24;
  std::vector<Vec3> cloud;
  Random random(2, 0, 0);
  for (int i = 0; i < kSide; ++i)
    for (int j = 0; j < kSide; ++j) cloud.push_back({i + 0.5, j + 0.5, 2 * random.uniform()});
  const HandMade made(cloud);
  const SurfacePoints points = made.points();
  Site site(points, {}, made.normal);
  auto at = [&](int i, int j) { return made.row_of[static_cast<std::size_t>(i * kSide + j)]; };
  for (int i = 0; i + 1 < kSide; ++i)
    for (int j = 0; j + 1 < kSide; ++j) {
      site.complex.add({at(i, j), at(i + 1, j), at(i + 1, j + 1)}, 3);
      site.complex.add({at(i, j), at(i + 1, j + 1), at(i, j + 1)}, 3);
    }
  EXPECT_TRUE(found_at_once(site, 1).empty());
  std::size_t unfolded = 0;
  for (std::uint32_t v = 0; v < site.complex.vertex_count(); ++v) unfolded += unfolded_fan(site, v);
  EXPECT_GT(unfolded, std::size_t{(kSide - 2) * (kSide - 2) / 2});
}

/// `links` around a middle, joined to it one after the other.
struct Wheel {
  explicit Wheel(const std::vector<Vec3>& links) : made(with_middle(links)), points(made.points()) {
    site.emplace(points, Params{}, made.normal);
    for (std::size_t k = 0; k < links.size(); ++k)
      site->complex.add({made.row_of[0], made.row_of[k + 1], made.row_of[(k + 1) % links.size() + 1]}, 3);
  }
  static std::vector<Vec3> with_middle(const std::vector<Vec3>& links) {
    std::vector<Vec3> all{{4.5, 4.5, 4.5}};
    for (const Vec3 link : links) all.push_back(Vec3{4.5, 4.5, 4.5} + link);
    return all;
  }
  bool unfolded() const { return unfolded_fan(*site, made.row_of[0]); }

  HandMade made;
  SurfacePoints points;
  std::optional<Site> site;
};

TEST(UnfoldedFan, IsOneTurnWithoutFolds) {
  const std::vector<Vec3> links{{1, 0, 0}, {0.5, 1, 0}, {-0.5, 1, 0}, {-1, 0, 0}, {-0.5, -1, 0}, {0.5, -1, 0}};
  EXPECT_TRUE(Wheel(links).unfolded());
  for (const Vec3 turn : {Vec3{0, 0, 1}, Vec3{1, 0, 0}, Vec3{0, 1, 0}}) {  // leaning every way, from either side
    std::vector<Vec3> leaning;
    for (const Vec3 p : links) leaning.push_back(p.x * unit(Vec3{1, 1, 0.3}) + p.y * unit(cross(turn, {1, 1, 0.3})));
    EXPECT_TRUE(Wheel(leaning).unfolded());
    std::reverse(leaning.begin(), leaning.end());
    EXPECT_TRUE(Wheel(leaning).unfolded());
  }
  std::vector<Vec3> folded = links;
  std::swap(folded[1], folded[2]);
  EXPECT_FALSE(Wheel(folded).unfolded());
}

TEST(UnfoldedFan, DoesNotTurnTwice) {
  std::vector<Vec3> links;  // a screw of two turns that closes
  for (const double height : {0.0, 0.3})
    for (const Vec3 p : {Vec3{1, 0, 0}, Vec3{0, 1, 0.1}, Vec3{-1, 0, 0.1}, Vec3{0, -1, 0.2}})
      links.push_back(p * (height > 0 ? 1.5 : 1) + Vec3{0, 0, height});
  EXPECT_FALSE(Wheel(links).unfolded());
}

TEST(UnfoldedFan, IsClosed) {
  Wheel wheel({{1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}});
  EXPECT_TRUE(wheel.unfolded());
  wheel.site->complex.remove(0);
  EXPECT_FALSE(wheel.unfolded());
}

}  // namespace
}  // namespace scanmill::stars
