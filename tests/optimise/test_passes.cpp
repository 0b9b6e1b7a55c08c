// SPDX-License-Identifier: Apache-2.0
// What the two passes promise on whole meshes.
#include <gtest/gtest.h>

#include "meshes.hpp"

namespace scanmill::optimise {
namespace {

TEST(SmoothPass, RestoresAnglesOfShuffledDiagonals) {
  for (const char* shape : {"sphere", "torus", "wavy sheet with a hole"}) {
    SCOPED_TRACE(shape);
    Mesh mesh = mesh_of(shape, 1.0);
    const double p5 = angle_p5(mesh);
    EXPECT_GT(shuffle_diagonals(mesh, 2.5, 20 * mesh.triangles.size(), 7), mesh.triangles.size());
    ASSERT_LT(angle_p5(mesh), 15);
    const auto before = support::check_mesh(mesh.positions, mesh.triangles, 2.5, 5);
    ASSERT_TRUE(before.sound()) << before;
    const auto report = run(mesh, {true, false}, limits_of(2.5));
    ASSERT_TRUE(report.ok());
    const auto after = support::check_mesh(mesh.positions, mesh.triangles, 2.5, 5);
    EXPECT_TRUE(after.sound()) << after;
    EXPECT_GE(angle_p5(mesh), 25);
    EXPECT_GE(angle_p5(mesh), p5 - 1);
    EXPECT_NEAR(report->smooth.angle_p5_after_deg, angle_p5(mesh), 1e-6);
    EXPECT_LT(report->smooth.angle_p5_before_deg, 15);
    EXPECT_FALSE(report->feature.done);
  }
}

TEST(SmoothPass, NeverLowersTheSortedAngles) {
  Mesh mesh = mesh_of("box", 1.0, 0.08);
  shuffle_diagonals(mesh, 2.5, 3 * mesh.triangles.size(), 8);
  const auto before = smallest_angles(mesh);
  ASSERT_TRUE(run(mesh, {true, false}, limits_of(2.5)).ok());
  const auto after = smallest_angles(mesh);
  for (std::size_t i = 0; i < before.size(); ++i) {
    if (std::abs(before[i] - after[i]) < 1e-9) continue;
    EXPECT_GT(after[i], before[i]);  // the first that differs
    break;
  }
  EXPECT_NE(before, after);
}

TEST(BothPasses, KeepEveryShapeSound) {
  for (const auto& shape : support::shapes()) {
    SCOPED_TRACE(shape.name);
    const double h = 1.0;
    Mesh mesh = mesh_of(shape.name, h, shape.greatest_noise > 0 ? 0.05 : 0);
    ASSERT_FALSE(mesh.triangles.empty());
    const Mesh start = mesh;
    const auto before = support::check_mesh(mesh.positions, mesh.triangles, 2.5 * h, 0);
    ASSERT_TRUE(before.sound()) << before;
    const auto report = run(mesh, {}, limits_of(2.5 * h));
    ASSERT_TRUE(report.ok());
    const auto after = support::check_mesh(mesh.positions, mesh.triangles, 2.5 * h, 0);
    EXPECT_TRUE(after.sound()) << after;
    EXPECT_EQ(mesh.positions, start.positions);
    EXPECT_EQ(numbers(topology_of(mesh)), numbers(topology_of(start)));
    EXPECT_TRUE(keeps_convention(mesh));
    EXPECT_EQ(mesh.patch.size(), mesh.triangles.size());
    EXPECT_LE(after.longest_edge, 2.5 * h);
    EXPECT_NEAR(report->feature.longest_edge_mm, after.longest_edge, 1e-9);
    EXPECT_GE(after.least_angle_deg, std::min(5.0, smallest_angles(start).front()) - 1e-9);
    EXPECT_LE(report->after_feature.normal_variation_rms, report->before_feature.normal_variation_rms);
  }
}

TEST(BothPasses, GiveTheSameBytesForAnyThreads) {
  Mesh start = mesh_of("box", 0.8, 0.06);
  shuffle_diagonals(start, 2, start.triangles.size(), 9);
  Mesh first = start;
  ASSERT_TRUE(run(first, {}, limits_of(2), 1).ok());
  EXPECT_NE(first.triangles, start.triangles);
  for (const int threads : {2, 7}) {
    Mesh again = start;
    ASSERT_TRUE(run(again, {}, limits_of(2), threads).ok());
    EXPECT_EQ(again.triangles, first.triangles) << threads;
    EXPECT_EQ(again.patch, first.patch) << threads;
  }
}

TEST(BothPasses, FindNothingLeftWhenRunAgain) {
  Mesh mesh = mesh_of("step", 1.0, 0.05);
  for (const Params pass : {Params{true, false}, Params{false, true}}) {
    ASSERT_TRUE(run(mesh, pass, limits_of(2.5)).ok());
    const Mesh ended = mesh;
    const auto again = run(mesh, pass, limits_of(2.5));
    ASSERT_TRUE(again.ok());
    EXPECT_EQ(again->smooth.swaps + again->feature.swaps, 0u);
    EXPECT_EQ(mesh.triangles, ended.triangles);
  }
}

/// Mean square distance of points of the triangles from the planes of the cube |x|, |y|, |z| = half, near its edges
/// only.
double square_off_cube(const Mesh& mesh, double half, double near_edge) {
  double sum = 0, count = 0;
  for (const Triangle& t : mesh.triangles)
    for (int i = 0; i <= 8; ++i)
      for (int j = 0; i + j <= 8; ++j) {
        const Vec3 p = mesh.positions[t[0]] * (i / 8.0) + mesh.positions[t[1]] * (j / 8.0) +
                       mesh.positions[t[2]] * ((8 - i - j) / 8.0);
        double x[3] = {std::abs(p.x), std::abs(p.y), std::abs(p.z)};
        std::sort(x, x + 3);
        if (x[1] < half - near_edge) continue;
        sum += (x[2] - half) * (x[2] - half);
        ++count;
      }
  return sum / count;
}

TEST(FeaturePass, BringsOutTheEdgesOfACube) {
  // Surface points of a cube of 20 mm, edges between the bins' centres.
  Mesh mesh;
  {
    auto meshed = support::mesh_points(support::box_points({0, 0, 0}, {20, 20, 20}, 60000, 5), support::what_of(1.3));
    ASSERT_TRUE(meshed.ok());
    mesh = std::move(meshed->surface.mesh);
  }
  ASSERT_TRUE(run(mesh, {true, false}, limits_of(3.25)).ok());
  const Mesh start = mesh;
  const auto report = run(mesh, {false, true}, limits_of(3.25));
  ASSERT_TRUE(report.ok());
  EXPECT_LT(square_off_cube(mesh, 10, 1), 0.7 * square_off_cube(start, 10, 1));
  EXPECT_NEAR(report->before_feature.dihedral_sum_deg, dihedral_sum(start), 1e-3);
  EXPECT_NEAR(report->after_feature.dihedral_sum_deg, dihedral_sum(mesh), 1e-3);
  EXPECT_LT(dihedral_sum(mesh), 0.9 * dihedral_sum(start));
  EXPECT_GE(angle_p5(mesh), 17);
}

TEST(FeaturePass, IsLeftOutOnRequest) {
  Mesh mesh = mesh_of("box", 1.0, 0.05);
  const auto report = run(mesh, {true, false}, limits_of(2.5));
  ASSERT_TRUE(report.ok());
  EXPECT_EQ(report->before_feature.inner_edges, 0u);
  EXPECT_GE(angle_p5(mesh), 25);
  const Mesh smooth = mesh;
  ASSERT_TRUE(run(mesh, {false, false}, limits_of(2.5)).ok());
  EXPECT_EQ(mesh.triangles, smooth.triangles);
}

TEST(BothPasses, KeepPatchBordersWhereTheyAre) {
  Mesh mesh = mesh_of("sphere", 1.0, 0.05);
  shuffle_diagonals(mesh, 2.5, 2 * mesh.triangles.size(), 4);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    mesh.patch[t] = mesh.positions[mesh.triangles[t][0]].x > 0 ? 5 : 2;
  auto borders = [](const Mesh& m) {
    std::vector<Edge> list;
    for (const auto& [edge, both] : edges_of(m))
      if (both.size() == 2 && m.patch[both[0]] != m.patch[both[1]]) list.push_back(edge);
    return list;
  };
  const auto before = borders(mesh);
  ASSERT_GT(before.size(), 30u);
  const auto of_five = std::count(mesh.patch.begin(), mesh.patch.end(), 5u);
  const auto report = run(mesh, {}, limits_of(2.5));
  ASSERT_TRUE(report.ok());
  EXPECT_GT(report->smooth.swaps, 100u);
  EXPECT_GT(report->smooth.refused.patch_border, 0u);
  EXPECT_EQ(borders(mesh), before);
  EXPECT_EQ(std::count(mesh.patch.begin(), mesh.patch.end(), 5u), of_five);
}

}  // namespace
}  // namespace scanmill::optimise
