// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>

#include "mesh/mesh.hpp"

namespace scanmill {
namespace {

Mesh mesh_of(std::vector<Vec3> positions, std::vector<Triangle> triangles) {
  Mesh mesh;
  mesh.positions = std::move(positions);
  mesh.triangles = std::move(triangles);
  return mesh;
}

/// Corners (0,0,0), (1,0,0), (0,1,0), (0,0,1), faces outward.
Mesh tetrahedron() {
  return mesh_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}});
}

/*  1---3---5
    | \ | \ |
    0---2---4   */
Mesh strip() {
  return mesh_of({{0, 0, 0}, {0, 1, 0}, {1, 0, 0}, {1, 1, 0}, {2, 0, 0}, {2, 1, 0}},
                 {{0, 2, 1}, {1, 2, 3}, {2, 4, 3}, {3, 4, 5}});
}

/// Five triangles round a ring with one half turn: corner n, n+1, n+2 (mod 5), alternately turned.
Mesh moebius() {
  Mesh mesh;
  mesh.positions = {{2, 0, 0}, {1, 2, 1}, {-2, 1, 0}, {-2, -1, 1}, {1, -2, 0}};
  for (std::uint32_t n = 0; n < 5; ++n) {
    const std::uint32_t a = n, b = (n + 1) % 5, c = (n + 2) % 5;
    mesh.triangles.push_back(n % 2 ? Triangle{b, a, c} : Triangle{a, b, c});
  }
  return mesh;
}

/*  Two fans without their bottoms that meet in their tips, vertex 0:
    1-2-3 around 0 above, 4-5-6 around 0 below   */
Mesh two_cones() {
  return mesh_of({{0, 0, 0}, {1, 0, 1}, {-1, 1, 1}, {-1, -1, 1}, {1, 0, -1}, {-1, 1, -1}, {-1, -1, -1}},
                 {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {0, 5, 4}, {0, 6, 5}, {0, 4, 6}});
}

/// Three wings on the edge 0-1.
Mesh book() {
  return mesh_of({{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {-1, -1, 0}}, {{0, 1, 2}, {0, 1, 3}, {0, 1, 4}});
}

/*  Two triangles whose holes meet in one vertex, 2:
    0---1
     \ /
      2
     / \
    3---4   */
Mesh bow_tie() { return mesh_of({{-1, 1, 0}, {1, 1, 0}, {0, 0, 0}, {-1, -1, 0}, {1, -1, 0}}, {{0, 2, 1}, {2, 3, 4}}); }

/*  Two sheets of three squares that meet in the point 7 alone:
    10-11 12-13-14
     |  |  |  |  |
     5--6--7--8--9
     |  |  |  |  |
     0--1--2  3--4   */
Mesh touching_sheets() {
  Mesh mesh;
  for (std::uint32_t n = 0; n < 15; ++n)
    mesh.positions.push_back({static_cast<double>(n % 5), static_cast<double>(n / 5), 0});
  for (const std::uint32_t a : {0u, 1u, 3u, 5u, 7u, 8u}) {
    mesh.triangles.push_back({a, a + 1, a + 6});
    mesh.triangles.push_back({a, a + 6, a + 5});
  }
  return mesh;
}

// ---- topology_of ----

TEST(TopologyOf, GivesTrianglesThatNameAVertexTwiceNoEdges) {
  Mesh mesh = tetrahedron();
  const TopologyCounts before = topology_of(mesh);
  mesh.triangles.push_back({0, 0, 1});
  const TopologyCounts after = topology_of(mesh);
  EXPECT_EQ(after.triangles, before.triangles + 1);
  EXPECT_EQ(after.edges, before.edges);
  EXPECT_EQ(after.boundary_edges, 0u);
  EXPECT_EQ(after.nonmanifold_edges, 0u);
  EXPECT_EQ(after.components, 1u);
}

TEST(TopologyOf, TetrahedronIsAClosedSphere) {
  const TopologyCounts counts = topology_of(tetrahedron());
  EXPECT_EQ(counts.vertices_used, 4u);
  EXPECT_EQ(counts.edges, 6u);
  EXPECT_EQ(counts.triangles, 4u);
  EXPECT_EQ(counts.euler, 2);
  EXPECT_EQ(counts.components, 1u);
  EXPECT_EQ(counts.boundary_edges + counts.boundary_loops + counts.nonmanifold_edges + counts.nonmanifold_vertices +
                counts.misoriented_edges,
            0u);
}

TEST(TopologyOf, StripIsADisc) {
  const TopologyCounts counts = topology_of(strip());
  EXPECT_EQ(counts.euler, 1);
  EXPECT_EQ(counts.boundary_edges, 6u);
  EXPECT_EQ(counts.boundary_loops, 1u);
  EXPECT_EQ(counts.edges, 9u);
  EXPECT_EQ(counts.misoriented_edges + counts.nonmanifold_edges + counts.nonmanifold_vertices, 0u);
}

TEST(TopologyOf, TurnedTriangleGivesMisorientedEdges) {
  Mesh mesh = strip();
  std::swap(mesh.triangles[1][0], mesh.triangles[1][1]);
  EXPECT_EQ(topology_of(mesh).misoriented_edges, 2u);
}

TEST(TopologyOf, MoebiusStripCannotBeOriented) {
  const TopologyCounts counts = topology_of(moebius());
  EXPECT_EQ(counts.euler, 0);
  EXPECT_EQ(counts.boundary_loops, 1u);
  EXPECT_EQ(counts.boundary_edges, 5u);
  EXPECT_EQ(counts.misoriented_edges, 1u);
  EXPECT_EQ(counts.nonmanifold_vertices, 0u);
}

TEST(TopologyOf, ConesThatTouchInAPointAreOneComponentWithABadVertex) {
  const TopologyCounts counts = topology_of(two_cones());
  EXPECT_EQ(counts.nonmanifold_vertices, 1u);
  EXPECT_EQ(counts.nonmanifold_edges, 0u);
  EXPECT_EQ(counts.components, 1u);
  EXPECT_EQ(counts.boundary_loops, 2u);
}

TEST(TopologyOf, EdgeWithThreeTrianglesIsNotManifold) {
  const TopologyCounts counts = topology_of(book());
  EXPECT_EQ(counts.nonmanifold_edges, 1u);
  EXPECT_EQ(counts.nonmanifold_vertices, 2u);
  EXPECT_EQ(counts.boundary_edges, 6u);
}

TEST(TopologyOf, LeavesOutVerticesThatNoTriangleUses) {
  Mesh mesh = tetrahedron();
  mesh.positions.push_back({9, 9, 9});
  EXPECT_EQ(topology_of(mesh).vertices_used, 4u);
  EXPECT_EQ(topology_of(mesh).components, 1u);
  EXPECT_EQ(topology_of(Mesh{}).components, 0u);
}

// ---- edge_neighbours ----

TEST(EdgeNeighbours, AreTheTrianglesAcrossEachEdge) {
  const Mesh mesh = strip();
  const auto across = edge_neighbours(mesh.positions.size(), mesh.triangles);
  constexpr std::uint32_t kNo = kNoTriangle;
  EXPECT_EQ(across, (std::vector<std::uint32_t>{kNo, 1, kNo, 0, 2, kNo, kNo, 3, 1, 2, kNo, kNo}));
}

TEST(EdgeNeighbours, AreMutual) {
  for (const Mesh& mesh : {tetrahedron(), moebius(), two_cones(), book(), touching_sheets()}) {
    const auto across = edge_neighbours(mesh.positions.size(), mesh.triangles);
    for (std::uint32_t c = 0; c < across.size(); ++c) {
      if (across[c] == kNoTriangle) continue;
      const auto first = across.begin() + 3 * across[c];
      EXPECT_EQ(std::count(first, first + 3, c / 3), 1) << "triangle " << c / 3 << " edge " << c % 3;
    }
  }
}

/// No one triangle is the neighbour where three meet.
TEST(EdgeNeighbours, EndAtEdgesWithThreeTriangles) {
  const Mesh mesh = book();
  for (const std::uint32_t t : edge_neighbours(mesh.positions.size(), mesh.triangles)) EXPECT_EQ(t, kNoTriangle);
}

// ---- border_loops ----

std::vector<std::vector<std::uint32_t>> loops_of(const Mesh& mesh) {
  std::vector<std::vector<std::uint32_t>> loops;
  for (const BorderLoop& loop : border_loops(mesh)) loops.push_back(loop.vertices);
  return loops;
}
using Loops = std::vector<std::vector<std::uint32_t>>;

TEST(BorderLoops, RunAgainstTheTrianglesFromTheirLeastVertex) {
  EXPECT_EQ(loops_of(tetrahedron()), Loops{});
  EXPECT_EQ(loops_of(strip()), (Loops{{0, 1, 3, 5, 4, 2}}));
}

TEST(BorderLoops, TellLengthAndPlace) {
  Mesh mesh = strip();
  mesh.offset = {10, 20, 30};
  const auto loops = border_loops(mesh);
  ASSERT_EQ(loops.size(), 1u);
  EXPECT_DOUBLE_EQ(loops[0].length_mm, 6);
  EXPECT_EQ(loops[0].centre, (Vec3{11, 20.5, 30}));
}

TEST(BorderLoops, TurnToTheirOwnFansEndWhereTwoMeet) {
  EXPECT_EQ(loops_of(bow_tie()), (Loops{{0, 1, 2}, {2, 4, 3}}));
  EXPECT_EQ(loops_of(two_cones()), (Loops{{1, 3, 2}, {4, 5, 6}}));
  EXPECT_EQ(loops_of(touching_sheets()), (Loops{{0, 5, 10, 11, 6, 7, 2, 1}, {3, 8, 7, 12, 13, 14, 9, 4}}));
}

TEST(BorderLoops, EndOnAMoebiusStripToo) {
  const auto loops = loops_of(moebius());
  ASSERT_EQ(loops.size(), 1u);
  EXPECT_EQ(loops[0].size(), 5u);
}

TEST(BorderLoops, EndAtATurnedTriangleToo) {
  Mesh mesh = strip();
  std::swap(mesh.triangles[1][0], mesh.triangles[1][1]);
  const auto loops = loops_of(mesh);
  ASSERT_EQ(loops.size(), 1u);
  EXPECT_EQ(loops[0].size(), 6u);
}

TEST(BorderLoops, WalkEveryOpenEdgeOfABook) {
  std::size_t edges = 0;
  for (const auto& loop : loops_of(book())) edges += loop.size();
  EXPECT_EQ(edges, 9u);  // each wing alone: the common edge is open to all three
}

// ---- single_fan_triangles, signed_volume ----

TEST(SingleFanTriangles, KeepsAllOfASoundMesh) {
  for (const Mesh& mesh : {tetrahedron(), strip(), moebius()})
    EXPECT_EQ(single_fan_triangles(mesh.positions.size(), mesh.triangles),
              std::vector<std::uint8_t>(mesh.triangles.size(), 1));
}

TEST(SingleFanTriangles, KeepsTheLargestFanThenTheFirst) {
  Mesh mesh = two_cones();
  EXPECT_EQ(single_fan_triangles(7, mesh.triangles), (std::vector<std::uint8_t>{1, 1, 1, 0, 0, 0}));
  mesh.triangles.erase(mesh.triangles.begin());  // now the second fan is larger
  EXPECT_EQ(single_fan_triangles(7, mesh.triangles), (std::vector<std::uint8_t>{0, 0, 1, 1, 1}));
}

TEST(SingleFanTriangles, LeavesOneFanEverywhere) {
  for (Mesh mesh : {two_cones(), book(), bow_tie(), touching_sheets()}) {
    const auto stays = single_fan_triangles(mesh.positions.size(), mesh.triangles);
    std::vector<Triangle> left;
    for (std::size_t t = 0; t < stays.size(); ++t)
      if (stays[t]) left.push_back(mesh.triangles[t]);
    mesh.triangles = left;
    EXPECT_FALSE(left.empty());
    EXPECT_EQ(topology_of(mesh).nonmanifold_vertices, 0u);
  }
}

TEST(SignedVolume, IsPositiveForOutwardFaces) {
  Mesh mesh = tetrahedron();
  EXPECT_DOUBLE_EQ(signed_volume(mesh), 1.0 / 6);
  for (Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
  EXPECT_DOUBLE_EQ(signed_volume(mesh), -1.0 / 6);
  for (Vec3& p : mesh.positions) p += {5, -7, 3};
  EXPECT_NEAR(signed_volume(mesh), -1.0 / 6, 1e-12);
  EXPECT_EQ(signed_volume(Mesh{}), 0);
}

}  // namespace
}  // namespace scanmill
