// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "base/random.hpp"
#include "flat_points.hpp"
#include "stars/complete.hpp"
#include "stars/vote.hpp"
#include "support/meshing.hpp"
#include "support/shapes.hpp"

namespace scanmill::stars {
namespace {

std::vector<Vec3> grid(int columns, int rows) {
  std::vector<Vec3> points;
  for (int i = 0; i < columns; ++i)
    for (int j = 0; j < rows; ++j) points.push_back({i + 0.5, j + 0.5, 0.5});
  return points;
}

/// A hexagon around its middle:   2 1
///                               3 0 6
///                                4 5
HandMade hexagon() {
  const double x = 0.5625, y = 0.96875;  // nearly regular, exact in binary
  return HandMade({{4.5, 4.5, 0.5},
                   {4.5 + x, 4.5 + y, 0.5},
                   {4.5 - x, 4.5 + y, 0.5},
                   {4.5 - 2 * x, 4.5, 0.5},
                   {4.5 - x, 4.5 - y, 0.5},
                   {4.5 + x, 4.5 - y, 0.5},
                   {4.5 + 2 * x, 4.5, 0.5}});
}

Vote vote_of(const HandMade& made, const std::vector<Star>& stars, double min_angle_deg, RefusalCounts& refused,
             const support::Workers& workers) {
  const auto ballots = ballots_of(made.points(), stars, {}, cos_of_degrees(min_angle_deg), workers.context());
  for (const Ballot& ballot : ballots) refused.angle += ballot.refused.angle;
  return count_votes(made.points(), ballots, &stars);
}

TEST(Star, OfSixNeighboursHasThemAllInTurn) {
  const HandMade made = hexagon();
  const support::Workers workers;
  RefusalCounts refused;
  const std::vector<Star> stars = stars_of(made.points(), {}, {}, refused, workers.context());
  const Star& star = stars[made.row_of[0]];
  ASSERT_EQ(star.size, 6);
  EXPECT_EQ(star.gaps, 0u);
  for (std::uint32_t k = 1; k <= 6; ++k) {
    const std::uint32_t a = made.row_of[k], b = made.row_of[k % 6 + 1];
    EXPECT_EQ(star.direction(a, b), 1) << k;
    EXPECT_EQ(star.direction(b, a), -1) << k;
    EXPECT_EQ(star.direction(a, made.row_of[(k + 1) % 6 + 1]), 0) << k;
  }
  EXPECT_EQ(stars[made.row_of[1]].size, 3);  // at the rim
  EXPECT_NE(stars[made.row_of[1]].gaps, 0u);
}

TEST(Star, EndsWhereG1Ends) {
  const HandMade made = hexagon();
  const support::Workers workers;
  RefusalCounts refused;
  const std::vector<Star> stars = stars_of(made.points(), {}, {1.0, 5}, refused, workers.context());
  EXPECT_EQ(stars[made.row_of[0]].size, 0);
}

TEST(MeshPoints, FillsAnExactGrid) {
  const HandMade made(grid(17, 11));
  const support::Workers workers;
  const auto surface = mesh_points(made.points(), {}, workers.context());
  ASSERT_TRUE(surface.ok());
  EXPECT_EQ(surface->triangles.size(), 2u * 16 * 10);
  EXPECT_EQ(surface->report.open_edges, 2u * (16 + 10));
  EXPECT_EQ(surface->report.unused_points, 0u);
  const auto found = support::check_mesh(made.at, surface->triangles, 2.5, 5);
  EXPECT_TRUE(found.sound()) << found;
}

TEST(MeshPoints, RefusesLimitsOutsideTheirRange) {
  const HandMade made = hexagon();
  const support::Workers workers;
  EXPECT_FALSE(mesh_points(made.points(), {2.6, 5}, workers.context()).ok());
  EXPECT_FALSE(mesh_points(made.points(), {0, 5}, workers.context()).ok());
  EXPECT_FALSE(mesh_points(made.points(), {2, 46}, workers.context()).ok());
}

TEST(MeshPoints, StopsWhenCancelled) {
  const HandMade made = hexagon();
  support::Workers workers;
  workers.cancel.set();
  const auto surface = mesh_points(made.points(), {}, workers.context());
  ASSERT_FALSE(surface.ok());
  EXPECT_EQ(surface.error().code, Code::Cancelled);
}

/// Points of a plane, one per four bins on average: more holes than mesh.
HandMade sieve() {
  Random random(5, 6, 7);
  std::vector<Vec3> at;
  for (int i = 0; i < 90; ++i)
    for (int j = 0; j < 90; ++j)
      if (random.uniform() < 0.4)
        at.push_back(support::snapped({i + 0.1 + 0.8 * random.uniform(), j + 0.1 + 0.8 * random.uniform(), 0.5}));
  return HandMade(at);
}

class Counted final : public Progress {
 public:
  explicit Counted(CancelFlag* cancel = nullptr) : cancel_(cancel) {}
  void stage(std::string_view name, std::uint64_t done, std::uint64_t total) override {
    if (name != "complete" || total == 0) return;
    ++calls;
    most = std::max(most, done);
    if (cancel_ != nullptr) cancel_->set();
  }
  std::uint64_t calls = 0, most = 0;

 private:
  CancelFlag* cancel_;
};

TEST(Complete, TellsThatItGoesOnAndStopsAtOnce) {
  const HandMade made = sieve();
  support::Workers workers;
  Counted watched;
  const auto surface = mesh_points(made.points(), {}, workers.context(), watched);
  ASSERT_TRUE(surface.ok());
  EXPECT_GT(surface->report.repairs_tried, 0u);
  EXPECT_GT(watched.calls, 3u);
  EXPECT_GE(watched.most, 64u);
  Counted stopping(&workers.cancel);
  const auto stopped = mesh_points(made.points(), {}, workers.context(), stopping);
  ASSERT_FALSE(stopped.ok());
  EXPECT_EQ(stopped.error().code, Code::Cancelled);
  EXPECT_LE(stopping.calls, 2u);
}

TEST(Complete, TriesASieveOnceAndLeavesItSound) {
  const HandMade made = sieve();
  const support::Workers workers;
  const auto surface = mesh_points(made.points(), {}, workers.context());
  ASSERT_TRUE(surface.ok());
  const Report& report = surface->report;
  EXPECT_GT(report.open_edges + report.unused_points, report.kept / 5);
  EXPECT_LT(report.repairs_tried, report.kept);
  const auto found = support::check_mesh(made.at, surface->triangles, 2.5, 5);
  EXPECT_TRUE(found.sound()) << found;
}

/// Stars written by hand over a square 0 1 2 3 with both diagonals wanted by somebody.
TEST(Vote, ConfirmsWhatAllThreeCornersHold) {
  const HandMade made({{0.5, 0.5, 0.5}, {1.5, 0.5, 0.5}, {1.5, 1.5, 0.5}, {0.5, 1.5, 0.5}});
  const auto row = [&](std::size_t n) { return made.row_of[n]; };
  std::vector<Star> stars(4);
  const auto hold = [&](std::size_t centre, std::vector<std::size_t> around) {
    Star& star = stars[row(centre)];
    for (const std::size_t n : around) star.vertex[star.size++] = row(n);
    star.gaps = 1u << (star.size - 1);
  };
  hold(0, {1, 2, 3});
  hold(1, {2, 0});
  hold(2, {3, 0, 1});
  hold(3, {0, 1, 2});  // disagrees: it wants the diagonal 1-3
  const support::Workers workers;
  RefusalCounts refused;
  const Vote vote = vote_of(made, stars, 5, refused, workers);
  ASSERT_EQ(vote.confirmed.size(), 1u);
  Triangle wanted{row(0), row(1), row(2)}, got = vote.confirmed[0];
  std::sort(wanted.begin(), wanted.end());
  std::sort(got.begin(), got.end());
  EXPECT_EQ(got, wanted);
  ASSERT_EQ(vote.candidates.size(), 3u);  // 0 2 3 twice, 3 0 1 and 3 1 2 once
  EXPECT_EQ(vote.candidates[0].votes, 2);
  EXPECT_EQ(vote.candidates[1].votes, 1);
  EXPECT_EQ(vote.candidates[2].votes, 1);
}

TEST(Vote, TurnsATriangleBelowG2IntoACandidate) {
  const HandMade made = hexagon();
  const support::Workers workers;
  RefusalCounts refused;
  const auto stars = stars_of(made.points(), {}, {}, refused, workers.context());
  EXPECT_EQ(vote_of(made, stars, 5, refused, workers).confirmed.size(), 6u);
  EXPECT_EQ(refused.angle, 0u);
  const Vote strict = vote_of(made, stars, 60, refused, workers);
  EXPECT_EQ(strict.confirmed.size(), 0u);
  EXPECT_EQ(strict.candidates.size(), 6u);
  EXPECT_EQ(refused.angle, 6u);
}

/// Two planes that meet at a ridge, frames with random signs: one side of the surface is found all the same.
TEST(Signs, AgreeAcrossACrease) {
  std::vector<Vec3> points, normals;
  Random random(3, 0, 1);
  const auto add = [&](Vec3 p, Vec3 n) {
    points.push_back(p);
    normals.push_back(random.uniform() < 0.5 ? n : -n);
  };
  for (int j = 0; j < 12; ++j) {
    for (int i = 0; i < 8; ++i) add({i + 0.5, j + 0.5, 0.5}, {0.05, 0, 1});
    add({8.5, j + 0.5, 0.5}, {1, 0, 1});  // the ridge
    for (int k = 1; k < 8; ++k) add({8.5, j + 0.5, 0.5 - k}, {1, 0, 0.05});
  }
  HandMade made(points, normals);
  const support::Workers workers;
  for (const bool seen : {false, true}) {
    if (seen) {  // one view that saw a single point from above
      const std::uint32_t row = made.row_of[0];
      made.sign_known[row] = 1;
      if (made.normal[row].z < 0) made.normal[row] = -made.normal[row];
    }
    const auto surface = mesh_points(made.points(), {}, workers.context());
    ASSERT_TRUE(surface.ok());
    const auto found = support::check_mesh(made.at, surface->triangles, 2.5, 5);
    EXPECT_TRUE(found.sound()) << found;
    EXPECT_EQ(found.components, 1u);
    EXPECT_EQ(found.vertices, points.size());
    const double side = dot(surface->normal[made.row_of[0]], {0, 0, 1});
    if (seen) {
      EXPECT_GT(side, 0);
      EXPECT_TRUE(surface->sign_known[made.row_of[5]]) << "not told to the rest of the component";
    }
    for (std::size_t p = 0; p < points.size(); ++p)
      EXPECT_GT(dot(surface->normal[made.row_of[p]], {1, 0, 1}) * side, 0) << p;
    for (const Triangle& t : surface->triangles) {
      const Vec3 n = cross(made.at[t[1]] - made.at[t[0]], made.at[t[2]] - made.at[t[0]]);
      EXPECT_GE(dot(n, {1, 0, 1}) * side, 0);  // 0: upright at the two ends of the ridge
    }
  }
}

Site site_over(const HandMade& made, const SurfacePoints& points) { return Site(points, {}, made.normal); }

/// A bow tie at the hexagon's middle: a fan of three and a single triangle.
TEST(Peel, LeavesTheLargestFan) {
  const HandMade made = hexagon();
  const SurfacePoints points = made.points();
  Site site = site_over(made, points);
  const auto add = [&](std::size_t a, std::size_t b) {
    return site.complex.add({made.row_of[0], made.row_of[a], made.row_of[b]}, 3);
  };
  const std::uint32_t lone = add(5, 6);
  add(1, 2);
  add(2, 3);
  const std::uint32_t last = add(3, 4);
  const std::vector<std::uint32_t> all = open_vertices(site);
  EXPECT_EQ(peel(site, all), 1u);
  EXPECT_FALSE(site.complex.alive(lone));
  EXPECT_TRUE(site.complex.alive(last));
  EXPECT_EQ(peel(site, all), 0u);
}

TEST(Site, KnowsFreeSectors) {
  const HandMade made = hexagon();
  const SurfacePoints points = made.points();
  Site site = site_over(made, points);
  const auto& r = made.row_of;
  site.complex.add({r[0], r[1], r[3]}, 3);  // over 2
  EXPECT_FALSE(site.sector_free(r[0], r[1], r[2]));
  EXPECT_FALSE(site.sector_free(r[0], r[6], r[2]));
  EXPECT_TRUE(site.sector_free(r[0], r[3], r[4]));
  EXPECT_TRUE(site.sector_free(r[0], r[6], r[1]));
  EXPECT_FALSE(site.sector_free(r[0], r[4], r[3])) << "five sixths of a turn";
}

TEST(Loops, RunRoundTheRimAndItsNotch) {
  const HandMade made = hexagon();
  const SurfacePoints points = made.points();
  Site site = site_over(made, points);
  const auto& r = made.row_of;
  for (std::size_t k = 1; k <= 6; ++k)
    if (k != 2) site.complex.add({r[0], r[k], r[k % 6 + 1]}, 3);
  // The missing sixth is part of the rim: one loop of seven.
  const auto loops = trace_loops(site, open_vertices(site), 60);
  ASSERT_EQ(loops.size(), 1u);
  EXPECT_EQ(loops[0].size(), 7u);
  Report report;
  insert_candidates(site, {{{r[0], r[2], r[3]}, 2, 1}, {{r[0], r[2], r[4]}, 1, 1}}, report);
  EXPECT_EQ(report.candidates_added, 1u);
  EXPECT_EQ(site.complex.open_edges(), 6);
}

/// Random triangles over points in a slab, each asked against all others.
TEST(Site, FindsEveryCrossingInReach) {
  std::vector<Vec3> cloud;
  Random random(11, 0, 1);
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j)
      for (int k = 0; k < 2; ++k) cloud.push_back({i + random.uniform(), j + random.uniform(), k + random.uniform()});
  const HandMade made(cloud);
  const SurfacePoints points = made.points();
  Site site = site_over(made, points);
  std::size_t crossing = 0, clear = 0;
  for (int n = 0; n < 3000; ++n) {
    const auto pick = [&] { return static_cast<std::uint32_t>(random.next() % cloud.size()); };
    const Triangle t{pick(), pick(), pick()};
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0] || !site.within_limits(t)) continue;
    bool meets = false;
    for (std::uint32_t k = 0; k < site.complex.triangle_count(); ++k)
      meets =
          meets || (site.complex.alive(k) && triangles_cross(site.corners(t), site.corners(site.complex.triangle(k))));
    ASSERT_EQ(site.crossing_of(t) != kNone, meets) << "triangle " << t[0] << " " << t[1] << " " << t[2];
    ++(meets ? crossing : clear);
    if (!meets && site.complex.edges_free(t)) site.complex.add(t, 3);
  }
  EXPECT_GT(crossing, 100u);
  EXPECT_GT(clear, 20u);
}

/// A hole that no rule may close: every attempt is undone, triangle for triangle.
TEST(Repair, ThatDoesNotHelpChangesNothing) {
  std::vector<Vec3> points;
  for (const Vec3 p : grid(14, 14))
    if (norm2(p - Vec3{7, 7, 0.5}) > 9) points.push_back(p);
  const HandMade made(points);
  const support::Workers workers;
  const auto surface = mesh_points(made.points(), {}, workers.context());
  ASSERT_TRUE(surface.ok());
  const SurfacePoints view = made.points();
  Site site = site_over(made, view);
  for (const Triangle& t : surface->triangles) site.complex.add(t, 3);
  const auto alive = [&] {
    std::vector<Triangle> list;
    for (std::uint32_t t = 0; t < site.complex.triangle_count(); ++t)
      if (site.complex.alive(t)) list.push_back(site.complex.triangle(t));
    std::sort(list.begin(), list.end());
    return list;
  };
  const auto before = alive();
  const std::int64_t open = site.complex.open_edges();
  Report report;
  std::vector<std::uint32_t> changed;
  const auto loops = trace_loops(site, open_vertices(site), 120);
  ASSERT_EQ(loops.size(), 2u);
  for (const Loop& loop : loops)
    for (int level = 0; level < 4; ++level) EXPECT_FALSE(repair_loop(site, loop, level, report, changed)) << level;
  EXPECT_EQ(report.repairs_tried, 8u);
  EXPECT_EQ(report.repairs_kept, 0u);
  EXPECT_EQ(alive(), before);
  EXPECT_EQ(site.complex.open_edges(), open);
  EXPECT_EQ(site.normal, made.normal);
}

}  // namespace
}  // namespace scanmill::stars
