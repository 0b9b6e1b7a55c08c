// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "geom/predicates.hpp"
#include "verify/meshes.hpp"
#include "verify/quality.hpp"

namespace scanmill::verify {
namespace {

Quality looked_at(const Mesh& mesh, int threads = 1) {
  const Workers workers(threads);
  auto found = quality_of(mesh, workers.context());
  EXPECT_TRUE(found.ok()) << (found.ok() ? "" : found.error().text());
  return found.ok() ? *found : Quality{};
}

TEST(QualityOf, KnowsACube) {
  const Quality q = looked_at(cube(2));
  EXPECT_TRUE(q.closed_manifold && q.orientable);
  EXPECT_EQ(q.topology.euler, 2);
  EXPECT_EQ(q.crossing_pairs, 0u);
  EXPECT_NEAR(q.area_mm2, 24, 1e-12);
  EXPECT_NEAR(q.volume_mm3, 8, 1e-12);
  EXPECT_NEAR(q.angles.least, 45, 1e-12);
  EXPECT_NEAR(q.angles.p50, 45, 1e-12);
  EXPECT_EQ(q.edges.least, 2);
  EXPECT_NEAR(q.edges.greatest, std::sqrt(8.0), 1e-15);
  ASSERT_EQ(q.components.size(), 1u);
  EXPECT_EQ(q.components[0].triangles, 12u);
  EXPECT_EQ(q.components[0].bounds.high, (Vec3{2, 2, 2}));
  EXPECT_TRUE(q.loops.empty());
}

TEST(QualityOf, ListsLoopsAndPieces) {
  Mesh mesh = flat_sheet(3, 1);
  const Mesh other = cube();
  const auto base = static_cast<std::uint32_t>(mesh.positions.size());
  for (const Vec3 p : other.positions) mesh.positions.push_back(p + Vec3{10, 0, 0});
  for (const Triangle& t : other.triangles) mesh.triangles.push_back({t[0] + base, t[1] + base, t[2] + base});
  mesh.patch.clear();
  mesh.positions.push_back({99, 99, 99});
  mesh.offset = {1000, 0, 0};
  const Quality q = looked_at(mesh);
  EXPECT_EQ(q.vertices_unused, 1u);
  ASSERT_EQ(q.components.size(), 2u);
  EXPECT_EQ(q.components[0].triangles, 18u);
  EXPECT_EQ(q.components[1].bounds.low, (Vec3{1010, 0, 0}));
  ASSERT_EQ(q.loops.size(), 1u);
  EXPECT_NEAR(q.loops[0].length_mm, 12, 1e-12);
  EXPECT_FALSE(q.closed_manifold);
  EXPECT_NEAR(q.largest_component_share, 0.6, 1e-15);
}

TEST(QualityOf, CountsTrianglesThatAreNone) {
  Mesh mesh = cube();
  mesh.triangles.push_back({3, 3, 5});
  mesh.triangles.push_back({1, 1, 1});
  mesh.triangles.push_back({1, 0, 2});  // turned over
  mesh.positions.push_back({0.5, 0, 0});
  mesh.triangles.push_back({0, 8, 1});  // no area
  mesh.patch.clear();
  const Quality q = looked_at(mesh);
  EXPECT_EQ(q.repeated_corners, 2u);
  EXPECT_EQ(q.duplicate_triangles, 1u);
  EXPECT_EQ(q.zero_area_triangles, 3u);
  EXPECT_EQ(q.angles.least, 0);
  EXPECT_EQ(q.topology.triangles, 16u);
  EXPECT_FALSE(q.closed_manifold);
}

TEST(QualityOf, TellsAMoebiusStripFromARing) {
  for (const bool twisted : {false, true}) {
    Mesh mesh;
    const std::uint32_t n = 12;
    const double x[] = {1, 0.866, 0.5, 0, -0.5, -0.866, -1, -0.866, -0.5, 0, 0.5, 0.866};
    for (std::uint32_t i = 0; i < n; ++i)
      for (const double z : {-0.2, 0.2}) mesh.positions.push_back({x[i] * 3, x[(i + 9) % 12] * 3, z});
    for (std::uint32_t i = 0; i < n; ++i) {
      std::uint32_t a = 2 * i, b = a + 1, c = 2 * ((i + 1) % n), d = c + 1;
      if (twisted && i == n - 1) std::swap(c, d);
      mesh.triangles.push_back({a, c, b});
      mesh.triangles.push_back({b, c, d});
    }
    EXPECT_EQ(looked_at(mesh).orientable, !twisted);
    EXPECT_EQ(looked_at(mesh).loops.size(), twisted ? 1u : 2u);
  }
}

TEST(QualityOf, FindsTheCrossingsThatTryingAllPairsFinds) {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    const Mesh mesh = soup(40 * seed, seed);
    std::vector<std::pair<std::uint32_t, std::uint32_t>> wanted;
    std::vector<bool> hit(mesh.triangles.size());
    auto corners = [&](std::uint32_t t) {
      const auto& [a, b, c] = mesh.triangles[t];
      return Corners{{mesh.positions[a], mesh.positions[b], mesh.positions[c]}, {a, b, c}};
    };
    auto proper = [&](const Triangle& t) { return t[0] != t[1] && t[1] != t[2] && t[2] != t[0]; };
    for (std::uint32_t s = 0; s < mesh.triangles.size(); ++s)
      for (std::uint32_t t = s + 1; t < mesh.triangles.size(); ++t) {
        Triangle u = mesh.triangles[s], v = mesh.triangles[t];
        std::sort(u.begin(), u.end());
        std::sort(v.begin(), v.end());
        if (!proper(u) || !proper(v) || u == v || !triangles_cross(corners(s), corners(t))) continue;
        wanted.push_back({s, t});
        hit[s] = hit[t] = true;
      }
    const Quality q = looked_at(mesh, seed % 2 == 0 ? 7 : 1);
    EXPECT_EQ(q.crossing_pairs, wanted.size());
    EXPECT_EQ(q.crossing_triangles, static_cast<std::uint64_t>(std::count(hit.begin(), hit.end(), true)));
    ASSERT_EQ(q.crossings.size(), std::min<std::size_t>(100, wanted.size()));
    for (std::size_t n = 0; n < q.crossings.size(); ++n)
      EXPECT_EQ(std::pair(q.crossings[n].first, q.crossings[n].second), wanted[n]);
  }
}

TEST(QualityOf, DoesNotDependOnThreads) {
  const Mesh mesh = soup(900, 77);
  const Quality one = looked_at(mesh, 1);
  for (const int threads : {2, 7}) {
    const Quality many = looked_at(mesh, threads);
    EXPECT_EQ(many.crossing_pairs, one.crossing_pairs);
    EXPECT_EQ(many.crossing_triangles, one.crossing_triangles);
    EXPECT_EQ(many.area_mm2, one.area_mm2);
    EXPECT_EQ(many.angles.histogram, one.angles.histogram);
    EXPECT_EQ(many.angles.mean, one.angles.mean);
    ASSERT_EQ(many.crossings.size(), one.crossings.size());
    for (std::size_t n = 0; n < one.crossings.size(); ++n) EXPECT_EQ(many.crossings[n].place, one.crossings[n].place);
  }
}

TEST(QualityOf, TakesAnEmptyMesh) {
  const Quality q = looked_at(Mesh{});
  EXPECT_EQ(q.topology.triangles, 0u);
  EXPECT_FALSE(q.closed_manifold);
}

TEST(QualityOf, RefusesWhatIsNoMesh) {
  const Workers workers;
  Mesh mesh = cube();
  mesh.triangles[4][1] = 8;
  auto found = quality_of(mesh, workers.context());
  ASSERT_FALSE(found.ok());
  EXPECT_NE(found.error().message.find("triangle 4"), std::string::npos) << found.error().message;
  mesh = cube();
  mesh.positions[5].y = std::numeric_limits<double>::quiet_NaN();
  found = quality_of(mesh, workers.context());
  ASSERT_FALSE(found.ok());
  EXPECT_NE(found.error().message.find("vertex 5"), std::string::npos) << found.error().message;
  mesh = cube();
  mesh.patch.pop_back();
  EXPECT_FALSE(quality_of(mesh, workers.context()).ok());
}

}  // namespace
}  // namespace scanmill::verify
