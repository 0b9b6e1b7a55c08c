// SPDX-License-Identifier: Apache-2.0
// What is told of clouds that make no mesh, of units that do not agree, and of noise that is none.
#include <gtest/gtest.h>

#include "base/random.hpp"
#include "pipeline/cloud_measure.hpp"
#include "pipeline/no_surface.hpp"
#include "pipeline/unit_hint.hpp"
#include "support/meshing.hpp"
#include "support/shapes.hpp"

namespace scanmill::pipeline {
namespace {

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

Bounds cube(double size) { return {{5, 5, 5}, {5 + size, 5 + size, 5 + size}}; }

TEST(UnitHint, NamesTheUnitThatMakesBothOneSize) {
  EXPECT_EQ(unit_hint(cube(100), cube(100), 1), "");
  EXPECT_EQ(unit_hint(cube(100), cube(80), 1), "");
  EXPECT_EQ(unit_hint(cube(100), cube(25), 1), "");  // a view of a part of it
  EXPECT_TRUE(has(unit_hint(cube(100), cube(0.1), 1), "if the cloud is in m, add --units m"));
  EXPECT_TRUE(has(unit_hint(cube(100), cube(9.5), 1), "add --units cm"));
  EXPECT_TRUE(has(unit_hint(cube(100), cube(4.2), 1), "add --units in"));
  EXPECT_TRUE(has(unit_hint(cube(100), cube(100000), 1000), "add --units mm"));
  EXPECT_TRUE(has(unit_hint(cube(0.1), cube(100), 1), "if the mesh is in m, convert it to mm first"));
  EXPECT_EQ(unit_hint(cube(100), {}, 1), "");
}

std::string why(const std::vector<Vec3>& points, const reduce::LatticeParams& lattice) {
  const support::Workers workers(2);
  const auto reduced = reduce::reduce_cloud(MemoryPoints(points), lattice, {}, workers.context());
  if (!reduced.ok()) return reduced.error().text();
  return no_surface_text(reduced->cloud, lattice, reduced->report.kept);
}

TEST(NoSurface, TellsTheCauseThatFits) {
  reduce::LatticeParams bins;
  bins.bin_mm = 0.1;
  EXPECT_TRUE(has(why({{0, 0, 0}, {10, 0, 0}, {0, 10, 0}}, bins), "of 3 points in 3 bins of 0.1 mm (0 kept): so few"));
  std::vector<Vec3> line;
  for (int n = 0; n < 200; ++n) line.push_back({n * 0.7, n * 0.4, n * 0.1});
  EXPECT_TRUE(has(why(line, bins), "lie on a line"));
  const auto ball = support::sphere_points({0, 0, 0}, 30, 1065, 3);
  EXPECT_TRUE(has(why(ball, bins), "bins are finer than the points"));
  reduce::LatticeParams many;
  many.target_points = 3000;
  EXPECT_TRUE(has(why(ball, many),
                  "lattice.target_points is 3000, more than so many points can fill; set it to at "
                  "most 266"));
}

/// A ball of 40 mm, its points moved in and out.
std::vector<Vec3> ball(std::size_t count, double noise) {
  Random random(7, 2, 9);
  std::vector<Vec3> points = support::sphere_points({0, 0, 0}, 40, count, 5);
  for (Vec3& p : points) p = p * (1 + noise * (2 * random.uniform() - 1) / 40);
  return points;
}

TEST(MeasureCloud, TakesCurvatureForNoNoise) {
  const support::Workers workers(2);
  const auto smooth = measure_cloud(MemoryPoints(ball(1500, 0)), workers.context());
  ASSERT_TRUE(smooth.ok());
  EXPECT_TRUE(smooth->shape_prevails);
  EXPECT_NEAR(*smooth->suggested_bin_mm, 2 * *smooth->spacing_mm, 1e-9);
  const auto noisy = measure_cloud(MemoryPoints(ball(60000, 0.5)), workers.context());
  ASSERT_TRUE(noisy.ok());
  EXPECT_FALSE(noisy->shape_prevails);
  EXPECT_NEAR(*noisy->suggested_bin_mm, 3 * *noisy->spacing_mm, 1e-9);
}

}  // namespace
}  // namespace scanmill::pipeline
