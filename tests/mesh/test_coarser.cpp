// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "mesh/coarser.hpp"

namespace scanmill {
namespace {

/// A height field of n x n squares of 1 mm, two triangles each.
Mesh field(std::uint32_t n) {
  Mesh mesh;
  for (std::uint32_t y = 0; y <= n; ++y)
    for (std::uint32_t x = 0; x <= n; ++x)
      mesh.positions.push_back({static_cast<double>(x), static_cast<double>(y), static_cast<double>(x * y % 7)});
  for (std::uint32_t y = 0; y < n; ++y)
    for (std::uint32_t x = 0; x < n; ++x) {
      const std::uint32_t a = y * (n + 1) + x, b = a + 1, c = a + n + 1, d = c + 1;
      mesh.triangles.push_back({a, b, d});
      mesh.triangles.push_back({a, d, c});
    }
  return mesh;
}

TEST(CoarserMesh, IsTheSameMeshBelowTheLimit) {
  const Mesh mesh = field(10);
  const CoarserMesh same = coarser_mesh(mesh, 200);
  EXPECT_EQ(same.cell_mm, 0);
  EXPECT_EQ(same.triangles, mesh.triangles);
  EXPECT_EQ(same.row_of.size(), mesh.positions.size());
}

TEST(CoarserMesh, KeepsTheLimitAndHoldsVerticesOfTheFineMeshOnly) {
  const Mesh mesh = field(120);
  for (const std::uint64_t most : {20000u, 5000u, 900u, 8u}) {
    const CoarserMesh coarse = coarser_mesh(mesh, most);
    EXPECT_LE(coarse.triangles.size(), most);
    if (most >= 900) {
      EXPECT_GT(coarse.triangles.size(), most / 8) << "not much more than needed is lost";
    }
    EXPECT_GT(coarse.cell_mm, 0);
    ASSERT_EQ(coarse.vertex.size(), mesh.positions.size());
    for (std::uint32_t row = 0; row < coarse.row_of.size(); ++row) EXPECT_EQ(coarse.vertex[coarse.row_of[row]], row);
    for (std::size_t v = 0; v < coarse.vertex.size(); ++v) {
      const Vec3 d = mesh.positions[v] - mesh.positions[coarse.row_of[coarse.vertex[v]]];
      EXPECT_LE(std::max({std::abs(d.x), std::abs(d.y), std::abs(d.z)}), coarse.cell_mm * (1 + 1e-9));
    }
    std::set<Triangle> once(coarse.triangles.begin(), coarse.triangles.end());
    EXPECT_EQ(once.size(), coarse.triangles.size());
    EXPECT_TRUE(std::is_sorted(coarse.triangles.begin(), coarse.triangles.end()));
    for (std::size_t t = 0; t < coarse.triangles.size(); ++t) {
      Triangle from = mesh.triangles[coarse.triangle[t]];
      const auto& fine = mesh.positions;
      const Vec3 outside = cross(fine[from[1]] - fine[from[0]], fine[from[2]] - fine[from[0]]);
      for (std::uint32_t& corner : from) corner = coarse.vertex[corner];
      std::rotate(from.begin(), std::min_element(from.begin(), from.end()), from.end());
      const auto at = [&](std::uint32_t row) { return mesh.positions[coarse.row_of[row]]; };
      const Triangle& x = coarse.triangles[t];
      const Vec3 normal = cross(at(x[1]) - at(x[0]), at(x[2]) - at(x[0]));
      EXPECT_GE(dot(normal, outside), 0);
      if (from != x) std::swap(from[1], from[2]);
      EXPECT_EQ(from, x);
    }
  }
}

TEST(CoarserMesh, EndsWhereEverythingLiesInOnePlace) {
  Mesh mesh = field(5);
  for (Vec3& p : mesh.positions) p = {3, 3, 3};
  EXPECT_EQ(coarser_mesh(mesh, 8).triangles.size(), 0u);
}

TEST(OpenEdges, AreTheRimOfASheetAndNoneOfAClosedMesh) {
  const std::uint32_t n = 6;
  const Mesh mesh = field(n);
  EXPECT_EQ(open_edges(mesh).size(), 4 * n);
  Mesh closed;
  closed.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  closed.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  EXPECT_TRUE(open_edges(closed).empty());
  closed.triangles.pop_back();
  using Edge = std::pair<std::uint32_t, std::uint32_t>;
  EXPECT_EQ(open_edges(closed), (std::vector<Edge>{{1, 2}, {1, 3}, {2, 3}}));
}

}  // namespace
}  // namespace scanmill
