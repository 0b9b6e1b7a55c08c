// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>

#include "merge/merge.hpp"

namespace scanmill::merge {
namespace {

/// Tetrahedra of four rows each, edge `size`, outward unless `inside_out`.
struct Parts {
  std::vector<Vec3> positions;
  std::vector<Triangle> triangles;
  std::vector<std::uint8_t> side_known;
  std::vector<std::uint32_t> patch;

  void add(Vec3 at, double size, bool inside_out, bool known) {
    const auto v = static_cast<std::uint32_t>(positions.size());
    for (const Vec3 p : {Vec3{0, 0, 0}, Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}})
      positions.push_back(at + p * size);
    for (Triangle t : {Triangle{0, 2, 1}, Triangle{0, 1, 3}, Triangle{1, 2, 3}, Triangle{0, 3, 2}}) {
      if (inside_out) std::swap(t[1], t[2]);
      patch.push_back(static_cast<std::uint32_t>(triangles.size()));
      triangles.push_back({v + t[0], v + t[1], v + t[2]});
    }
    side_known.insert(side_known.end(), {static_cast<std::uint8_t>(known), 0, 0, 0});
  }
  Input input(Vec3 offset = {}) const { return {positions, offset, side_known, triangles, patch}; }
};

TEST(MergeComponents, DropsStraysAndListsThem) {
  Parts parts;
  for (int n = 0; n < 3; ++n) parts.add({10.0 * n, 0, 0}, 1, false, true);
  // A lone triangle among 13: below a tenth.
  parts.positions.insert(parts.positions.end(), {{50, 1, 2}, {51, 1, 2}, {50, 2, 3}});
  parts.side_known.insert(parts.side_known.end(), 3, 1);
  parts.triangles.push_back({12, 13, 14});
  parts.patch.push_back(99);
  const Merged merged = merge_components(parts.input({100, 0, 0}), {10, 0.1});
  EXPECT_EQ(merged.components, 3u);
  EXPECT_EQ(merged.mesh.triangles.size(), 12u);
  ASSERT_EQ(merged.strays.size(), 1u);
  EXPECT_EQ(merged.strays[0].triangles, 1u);
  EXPECT_EQ(merged.strays[0].vertices, 3u);
  EXPECT_EQ(merged.strays[0].bounds.low, (Vec3{150, 1, 2}));
  EXPECT_EQ(merged.strays[0].bounds.high, (Vec3{151, 2, 3}));
  EXPECT_EQ(std::count(merged.mesh.patch.begin(), merged.mesh.patch.end(), 99u), 0);
  EXPECT_EQ(merge_components(parts.input(), {10, 0.05}).strays.size(), 0u);
}

/// The grid of 5 x 5 corners at height(i, j), upside down unless `up`.
Parts sheet(bool up, double (*height)(int, int)) {
  Parts parts;
  for (int j = 0; j < 5; ++j)
    for (int i = 0; i < 5; ++i) parts.positions.push_back({10.0 * i, 10.0 * j, height(i, j)});
  for (std::uint32_t j = 0; j < 4; ++j)
    for (std::uint32_t i = 0; i < 4; ++i)
      for (Triangle t :
           {Triangle{5 * j + i, 5 * j + i + 1, 5 * j + i + 6}, {5 * j + i, 5 * j + i + 6, 5 * j + i + 5}}) {
        if (!up) std::swap(t[1], t[2]);
        parts.patch.push_back(0);
        parts.triangles.push_back(t);
      }
  parts.side_known.assign(parts.positions.size(), 0);
  return parts;
}

double normals_up(const Mesh& mesh) {
  double up = 0;
  for (const Triangle& t : mesh.triangles)
    up += cross(mesh.positions[t[1]] - mesh.positions[t[0]], mesh.positions[t[2]] - mesh.positions[t[0]]).z;
  return up;
}

TEST(MergeComponents, TurnsGroundUpwardAndABowlAsItBulges) {
  // A valley bulges downward; as ground it is still seen from above.
  const auto valley = [](int i, int) { return 0.5 * (i - 2) * (i - 2); };
  const auto bowl = [](int i, int j) { return 4.0 * ((i - 2) * (i - 2) + (j - 2) * (j - 2)); };
  for (const bool up : {true, false}) {
    EXPECT_GT(normals_up(merge_components(sheet(up, valley).input(), {10, 0.1}).mesh), 0) << up;
    EXPECT_LT(normals_up(merge_components(sheet(up, bowl).input(), {10, 0.1}).mesh), 0) << up;
  }
  Parts seen = sheet(false, valley);
  seen.side_known[7] = 1;
  EXPECT_LT(normals_up(merge_components(seen.input(), {10, 0.1}).mesh), 0);  // the views know better
}

TEST(MergeComponents, NeverDropsTheLargest) {
  Parts parts;
  parts.add({}, 1, false, true);
  parts.add({5, 0, 0}, 1, false, true);  // as large: neither is the lesser one
  EXPECT_EQ(merge_components(parts.input(), {10, 1.0}).components, 2u);
  parts.triangles.pop_back();
  parts.patch.pop_back();
  const Merged merged = merge_components(parts.input(), {10, 1.0});
  EXPECT_EQ(merged.components, 1u);
  EXPECT_EQ(merged.mesh.triangles.size(), 4u);
}

TEST(MergeComponents, TurnsOutwardWhatNoViewKnows) {
  Parts parts;
  parts.add({}, 1, true, false);
  parts.add({5, 0, 0}, 1, false, false);
  parts.add({10, 0, 0}, 1, true, true);  // seen from inside: left as it is
  const Merged merged = merge_components(parts.input(), {});
  EXPECT_EQ(merged.turned_components, 1u);
  EXPECT_EQ(merged.turned_by_volume, 2u);
  for (std::uint32_t part = 0; part < 3; ++part) {
    Mesh one = merged.mesh;
    std::erase_if(one.triangles, [&](const Triangle& t) { return t[0] / 4 != part; });
    EXPECT_EQ(signed_volume(one) > 0, part < 2) << part;
    EXPECT_EQ(topology_of(one).misoriented_edges, 0u);
  }
}

TEST(MergeComponents, NumbersVerticesInRowOrderAndSortsTriangles) {
  Parts parts;
  parts.add({}, 1, false, true);
  parts.positions.insert(parts.positions.begin() + 2, {9, 9, 9});  // a row without triangle
  parts.side_known.insert(parts.side_known.begin() + 2, 0);
  for (Triangle& t : parts.triangles)
    for (std::uint32_t& v : t) v += v >= 2;
  std::reverse(parts.triangles.begin(), parts.triangles.end());
  const Merged merged = merge_components(parts.input(), {});
  EXPECT_EQ(merged.vertex_row, (std::vector<std::uint32_t>{0, 1, 3, 4}));
  ASSERT_EQ(merged.mesh.positions.size(), 4u);
  EXPECT_EQ(merged.mesh.positions[2], (Vec3{0, 1, 0}));
  EXPECT_TRUE(std::is_sorted(merged.mesh.triangles.begin(), merged.mesh.triangles.end()));
  for (const Triangle& t : merged.mesh.triangles) EXPECT_EQ(*std::min_element(t.begin(), t.end()), t[0]);
  // Patches go with their triangles: number p was the p-th from the end before the reversal.
  for (std::size_t t = 0; t < 4; ++t) {
    const Triangle& x = merged.mesh.triangles[t];
    Triangle rows{merged.vertex_row[x[0]], merged.vertex_row[x[1]], merged.vertex_row[x[2]]};
    const auto at = std::find(parts.triangles.begin(), parts.triangles.end(), rows);
    ASSERT_NE(at, parts.triangles.end());
    EXPECT_EQ(merged.mesh.patch[t], parts.patch[static_cast<std::size_t>(at - parts.triangles.begin())]);
  }
}

TEST(MergeComponents, OfNothingIsNothing) {
  const Merged merged = merge_components(Parts().input(), {});
  EXPECT_EQ(merged.components, 0u);
  EXPECT_TRUE(merged.mesh.triangles.empty());
}

}  // namespace
}  // namespace scanmill::merge
