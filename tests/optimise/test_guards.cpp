// SPDX-License-Identifier: Apache-2.0
// Each guard on a mesh drawn for it.
#include <gtest/gtest.h>

#include "meshes.hpp"

namespace scanmill::optimise {
namespace {

/*     3
      /|\        the long diagonal 2-3 is in; 0-1 would be better
     0 | 1       (0 and 1 a step apart, 2 and 3 far)
      \|/
       2     */
Mesh kite(double reach = 2, double lift = 0) {
  Mesh mesh;
  mesh.positions = {{-1, 0, 0}, {1, 0, 0}, {0, -reach, lift}, {0, reach, lift}};
  mesh.triangles = {{0, 2, 3}, {1, 3, 2}};
  return mesh;
}

TEST(Guards, LetTheBetterDiagonalIn) {
  Mesh mesh = kite();
  const auto report = run(mesh, {true, false}, limits_of(5));
  ASSERT_TRUE(report.ok());
  EXPECT_EQ(report->smooth.swaps, 1u);
  EXPECT_EQ(report->smooth.rounds, 1u);
  EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{0, 1, 3}, {0, 2, 1}}));
  EXPECT_TRUE(mesh.patch.empty());
}

TEST(Guards, RefuseLongEdges) {
  Mesh mesh = kite();
  const auto report = run(mesh, {true, false}, limits_of(1.9));
  ASSERT_TRUE(report.ok());
  EXPECT_EQ(report->smooth.swaps, 0u);
  EXPECT_EQ(report->smooth.refused.range, 1u);
}

TEST(Guards, RefuseSmallAnglesEvenIfBetter) {
  Mesh mesh = kite(20);  // 5.7 degrees at the tips against 2 x 2.9
  const auto report = run(mesh, {true, false}, limits_of(50, 10));
  ASSERT_TRUE(report.ok());
  EXPECT_EQ(report->smooth.swaps, 0u);
  EXPECT_EQ(report->smooth.refused.angle, 1u);
}

TEST(Guards, RefuseWhatIsNotConvex) {
  Mesh mesh = kite();
  mesh.positions[1] = {-0.5, 0.2, 0};  // an arrowhead: 0-1 would run outside
  mesh.triangles = {{0, 2, 1}, {0, 1, 3}};
  std::swap(mesh.positions[1], mesh.positions[2]);
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  const auto before = mesh.triangles;
  ASSERT_TRUE(run(mesh, {}, limits_of(50, 0)).ok());
  EXPECT_EQ(mesh.triangles, before);
}

/// A tube of triangular section, open at both ends: a ridge P0 P1 ..., and Q and R below it halfway between. Q0 R0 is
/// an edge of the floor and the other diagonal of the long quadrilateral around P0 P1.
Mesh triangular_tube() {
  constexpr std::uint32_t n = 5;
  Mesh mesh;
  for (std::uint32_t i = 0; i < n; ++i) {
    mesh.positions.push_back({3.0 * i, 0, 0.9});
    mesh.positions.push_back({3.0 * i + 1.5, 0.5, 0});
    mesh.positions.push_back({3.0 * i + 1.5, -0.5, 0});
  }
  for (std::uint32_t i = 0; i + 1 < n; ++i) {
    const std::uint32_t p = 3 * i, q = p + 1, r = p + 2;
    for (const Triangle& t :
         {Triangle{p, p + 3, q}, {q, p + 3, q + 3}, {p + 3, p, r}, {r, r + 3, p + 3}, {q, q + 3, r + 3}, {q, r + 3, r}})
      mesh.triangles.push_back(t);
  }
  to_convention(mesh);
  return mesh;
}

TEST(Guards, RefuseAnEdgeThatIsThereAlready) {
  Mesh mesh = triangular_tube();
  const TopologyCounts before = topology_of(mesh);
  ASSERT_EQ(before.nonmanifold_edges + before.misoriented_edges + before.nonmanifold_vertices, 0u);
  const auto report = run(mesh, {true, false}, limits_of(50, 0));
  ASSERT_TRUE(report.ok());
  EXPECT_GE(report->smooth.refused.edge_exists, 2u);
  EXPECT_EQ(numbers(topology_of(mesh)), numbers(before));
  EXPECT_TRUE(support::check_mesh(mesh.positions, mesh.triangles, 50, 0).duplicate_triangles == 0);
}

/// A roof over the kite's quadrilateral and a triangle that hangs between the two diagonals: 2-3 is low, 0-1 high.
Mesh kite_with_obstacle(double height) {
  Mesh mesh = kite(2, -1);  // ends of the old diagonal 1 mm below those of the new
  mesh.positions.insert(mesh.positions.end(), {{-0.2, 3, height}, {0.2, 3, height}, {0, -0.3, height}});
  mesh.triangles.push_back({4, 6, 5});
  return mesh;
}

TEST(Guards, RefuseToCutThroughAnotherTriangle) {
  Mesh between = kite_with_obstacle(-0.5), above = kite_with_obstacle(0.5);
  for (Mesh* mesh : {&between, &above})
    ASSERT_EQ(support::check_mesh(mesh->positions, mesh->triangles, 50, 0).crossing_pairs, 0u);
  const auto held = run(between, {true, false}, limits_of(5)), free = run(above, {true, false}, limits_of(5));
  ASSERT_TRUE(held.ok() && free.ok());
  EXPECT_EQ(held->smooth.swaps, 0u);
  EXPECT_EQ(held->smooth.refused.crossing, 1u);
  EXPECT_EQ(free->smooth.swaps, 1u);
  EXPECT_EQ(support::check_mesh(above.positions, above.triangles, 50, 0).crossing_pairs, 0u);
}

TEST(Guards, LetOnlyOneOfTwoSwapsThatWouldMeet) {
  // Two kites, one upside down above the other: each new diagonal alone is free, both together would cut.
  Mesh mesh = kite(2, -1);
  for (const Vec3 p : {Vec3{0, -1.1, -0.4}, Vec3{0, 1.1, -0.4}, Vec3{-2.2, 0, 0.7}, Vec3{2.2, 0, 0.7}})
    mesh.positions.push_back(p);
  mesh.triangles.push_back({4, 6, 7});
  mesh.triangles.push_back({5, 7, 6});
  to_convention(mesh);
  auto crossings = [](const Mesh& m) { return support::check_mesh(m.positions, m.triangles, 50, 0).crossing_pairs; };
  ASSERT_EQ(crossings(mesh), 0u);
  auto alone = [&](std::uint32_t first) {
    Mesh one = mesh;
    std::erase_if(one.triangles, [&](const Triangle& t) { return (t[0] >= 4) != (first >= 4); });
    const auto report = run(one, {true, false}, limits_of(5));
    return report.ok() ? report->smooth.swaps : 0;
  };
  EXPECT_EQ(alone(0), 1u);
  EXPECT_EQ(alone(4), 1u);
  const auto report = run(mesh, {true, false}, limits_of(5));
  ASSERT_TRUE(report.ok());
  EXPECT_EQ(report->smooth.swaps, 1u);
  EXPECT_EQ(report->smooth.refused.crossing, 1u);
  EXPECT_EQ(crossings(mesh), 0u);
}

/// Two rough sheets so close that their triangles' tetrahedra overlap everywhere.
Mesh close_sheets(std::uint64_t seed, double gap) {
  constexpr std::uint32_t n = 14;
  Random random(seed, 2, 2);
  Mesh mesh;
  std::vector<double> rough;
  for (std::uint32_t i = 0; i < n * n; ++i) rough.push_back(0.5 * random.uniform());
  for (std::uint32_t sheet = 0; sheet < 2; ++sheet)
    for (std::uint32_t i = 0; i < n; ++i)
      for (std::uint32_t j = 0; j < n; ++j)
        mesh.positions.push_back(support::snapped({i + 0.2 * random.uniform(), j + 0.2 * random.uniform(),
                                                   rough[i * n + j] + gap * sheet * (0.5 + random.uniform())}));
  for (std::uint32_t sheet = 0; sheet < 2; ++sheet)
    for (std::uint32_t i = 0; i + 1 < n; ++i)
      for (std::uint32_t j = 0; j + 1 < n; ++j) {
        const std::uint32_t a = sheet * n * n + i * n + j, b = a + n, c = b + 1, d = a + 1;
        Triangle s{a, b, c}, t{a, c, d};
        if ((i * 7 + j * 3 + i * j) % 2 == 0) s = {a, b, d}, t = {b, c, d};
        if (sheet == 0) std::swap(s[1], s[2]), std::swap(t[1], t[2]);
        mesh.triangles.push_back(s);
        mesh.triangles.push_back(t);
      }
  to_convention(mesh);
  return mesh;
}

TEST(Guards, KeepCloseSheetsApart) {
  std::uint64_t refused = 0, swaps = 0, sound = 0;
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    Mesh mesh = close_sheets(seed, 0.12);
    const auto before = support::check_mesh(mesh.positions, mesh.triangles, 50, 0);
    if (before.crossing_pairs > 0) continue;  // not a case
    ++sound;
    const auto report = run(mesh, {}, limits_of(3));
    ASSERT_TRUE(report.ok());
    const auto after = support::check_mesh(mesh.positions, mesh.triangles, 50, 0);
    EXPECT_TRUE(after.sound()) << seed << ": " << after;
    refused += report->smooth.refused.crossing + report->feature.refused.crossing;
    swaps += report->smooth.swaps + report->feature.swaps;
  }
  EXPECT_GT(sound, 0u);
  EXPECT_GT(swaps, 100u);
  EXPECT_GT(refused, 10u);
}

TEST(Guards, LeaveWhatIsNotManifoldAlone) {
  Mesh three = kite();  // a third leaf at the edge 2-3
  three.positions.push_back({0, 0, 3});
  three.triangles.push_back({2, 3, 4});
  Mesh touching = kite();  // a second kite at vertex 0
  touching.positions.insert(touching.positions.end(), {{-3, 0, 1}, {-2, -2, 1}, {-2, 2, 1}});
  touching.triangles.push_back({0, 6, 5});
  touching.triangles.push_back({4, 5, 6});
  Mesh against = kite();  // the second triangle runs the other way
  std::swap(against.triangles[1][1], against.triangles[1][2]);
  for (Mesh* mesh : {&three, &touching, &against}) {
    to_convention(*mesh);
    const auto before = mesh->triangles;
    const auto report = run(*mesh, {}, limits_of(5, 0));
    ASSERT_TRUE(report.ok());
    EXPECT_EQ(mesh->triangles, before);
  }
}

TEST(Optimise, LeavesTheMeshWhenCancelled) {
  Mesh mesh = kite();
  const auto before = mesh.triangles;
  support::Workers workers(2);
  workers.cancel.set();
  const auto report = optimise(mesh, {}, limits_of(5), workers.context());
  ASSERT_FALSE(report.ok());
  EXPECT_EQ(report.error().code, Code::Cancelled);
  EXPECT_EQ(mesh.triangles, before);
}

TEST(Optimise, RefusesLimitsThatAreNone) {
  Mesh mesh = kite();
  for (const Limits limits : {Limits{0, 0.99}, Limits{-1, 0.99}, Limits{5, 0.2}, Limits{5, 1.5}}) {
    const auto report = run(mesh, {}, limits);
    ASSERT_FALSE(report.ok());
    EXPECT_EQ(report.error().code, Code::BadParameter);
  }
}

TEST(Optimise, TakesAnEmptyMesh) {
  Mesh mesh;
  const auto report = run(mesh, {}, limits_of(5));
  ASSERT_TRUE(report.ok());
  EXPECT_EQ(report->smooth.swaps, 0u);
}

TEST(Params, HaveARowForEachPass) {
  Params params;
  ASSERT_EQ(Params::fields().size(), 2u);
  EXPECT_EQ(Params::fields()[0].name, "smooth");
  EXPECT_EQ(Params::fields()[1].name, "feature");
  EXPECT_TRUE(problems_of(Params::fields(), &params).empty());
}

}  // namespace
}  // namespace scanmill::optimise
