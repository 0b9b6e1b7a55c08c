// SPDX-License-Identifier: Apache-2.0
// Both passes on meshes of scans: the demo solids, whose true surface is known, and ten raw views of the Stanford
// bunny.
#include <gtest/gtest.h>

#include <algorithm>
#include <iostream>
#include <map>

#include "cloud/cloud.hpp"
#include "geom/angles.hpp"
#include "geom/predicates.hpp"
#include "optimise/optimise.hpp"
#include "pipeline/discovery.hpp"
#include "pipeline/scan_points.hpp"
#include "pipeline/surface.hpp"
#include "simulate/demo_plans.hpp"
#include "support/temp_folder.hpp"

namespace scanmill {
namespace {

struct Workers {
  ChunkLoop loop{2};
  CancelFlag cancel;
  Context context() const { return {loop, cancel}; }
};

Mesh mesh_of(const PointSource& points, double h, const Context& context) {
  pipeline::What what;
  what.lattice.bin_mm = h;
  const auto reduced = reduce::reduce_cloud(points, what.lattice, what.reduce, context);
  if (!reduced.ok()) return {};
  NoProgress progress;
  auto surface = pipeline::mesh_surface(reduced->cloud, reduced->report.bounds, what, context, progress);
  return surface.ok() ? std::move(surface->mesh) : Mesh{};
}

double angle_p5(const Mesh& mesh) {
  std::vector<double> cosines;
  for (const Triangle& t : mesh.triangles) {
    double most = -1;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 p = mesh.positions[t[k]];
      most = std::max(most, dot(unit(mesh.positions[t[(k + 1) % 3]] - p), unit(mesh.positions[t[(k + 2) % 3]] - p)));
    }
    cosines.push_back(most);
  }
  std::sort(cosines.begin(), cosines.end(), std::greater<>());
  return acos_degrees(cosines[cosines.size() / 20]);
}

/// Every pair of triangles whose boxes share a cell of edge `cell`.
std::size_t crossings(const Mesh& mesh, double cell) {
  auto corners = [&](std::uint32_t t) {
    const Triangle& k = mesh.triangles[t];
    return Corners{{mesh.positions[k[0]], mesh.positions[k[1]], mesh.positions[k[2]]}, {k[0], k[1], k[2]}};
  };
  std::map<std::array<int, 3>, std::vector<std::uint32_t>> cells;
  auto at = [&](double x) { return static_cast<int>(std::floor(x / cell)); };
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    Bounds box;
    for (const std::uint32_t v : mesh.triangles[t]) box.add(mesh.positions[v]);
    for (int x = at(box.low.x); x <= at(box.high.x); ++x)
      for (int y = at(box.low.y); y <= at(box.high.y); ++y)
        for (int z = at(box.low.z); z <= at(box.high.z); ++z) cells[{x, y, z}].push_back(t);
  }
  std::size_t count = 0;
  for (const auto& [where, list] : cells)
    for (std::size_t i = 0; i < list.size(); ++i)
      for (std::size_t j = 0; j < i; ++j) count += triangles_cross(corners(list[i]), corners(list[j]));
  return count;
}

/// Root mean square distance to the solid of points of the triangles: of all, or of those that lie near its edges,
/// where the normal of the solid turns by more than 25 degrees within 0.4 h.
double rms_off(const Mesh& mesh, const simulate::Object& object, double h, bool near_edges) {
  double sum = 0, count = 0;
  for (const Triangle& t : mesh.triangles)
    for (int i = 0; i < 3; ++i)
      for (int j = 0; i + j < 3; ++j) {
        const double u = (i + 1 / 3.0) / 3, v = (j + 1 / 3.0) / 3;
        const Vec3 p =
            mesh.positions[t[0]] * (1 - u - v) + mesh.positions[t[1]] * u + mesh.positions[t[2]] * v + mesh.offset;
        if (near_edges) {
          const Vec3 n = simulate::normal_at(object, p), e = perpendicular(n), f = cross(n, e);
          double least = 1;
          for (const Vec3 step : {e, f, -e, -f})
            least = std::min(least, dot(n, simulate::normal_at(object, p + step * (0.4 * h))));
          if (least > 0.906) continue;
        }
        const double d = object.surface_distance(p);
        sum += d * d;
        ++count;
      }
  EXPECT_GT(count, 200);
  return std::sqrt(sum / count);
}

void expect_same_topology(const Mesh& a, const Mesh& b) {
  const TopologyCounts s = topology_of(a), t = topology_of(b);
  EXPECT_EQ(s.vertices_used, t.vertices_used);
  EXPECT_EQ(s.triangles, t.triangles);
  EXPECT_EQ(s.edges, t.edges);
  EXPECT_EQ(s.boundary_edges, t.boundary_edges);
  EXPECT_EQ(s.boundary_loops, t.boundary_loops);
  EXPECT_EQ(s.nonmanifold_edges, t.nonmanifold_edges);
  EXPECT_EQ(s.nonmanifold_vertices, t.nonmanifold_vertices);
  EXPECT_EQ(s.misoriented_edges, t.misoriented_edges);
  EXPECT_EQ(s.components, t.components);
  EXPECT_EQ(s.euler, t.euler);
}

/// Swaps edges of a copy and checks what holds for every scan.
Mesh optimised(const Mesh& start, bool feature, double h, const Context& context) {
  Mesh mesh = start;
  const optimise::Limits limits{2.5 * h, cos_of_degrees(5)};
  const auto report = optimise::optimise(mesh, {true, feature}, limits, context);
  EXPECT_TRUE(report.ok());
  if (!report.ok()) return mesh;
  expect_same_topology(start, mesh);
  EXPECT_EQ(crossings(mesh, 2.5 * h), 0u);
  for (const Triangle& t : mesh.triangles)
    EXPECT_TRUE(within_range(mesh.positions[t[0]], mesh.positions[t[1]], mesh.positions[t[2]], limits.range_mm));
  const double p5 = angle_p5(mesh);
  EXPECT_GE(p5, feature ? 17 : 25);
  const optimise::PassReport& last = feature ? report->feature : report->smooth;
  EXPECT_NEAR(last.angle_p5_after_deg, p5, 1e-6);
  if (feature) {
    const auto &before = report->before_feature, &after = report->after_feature;
    EXPECT_LT(after.dihedral_sum_deg, before.dihedral_sum_deg);
    EXPECT_LE(after.sharp_edges, before.sharp_edges);
    EXPECT_LE(after.sharp_length_mm, before.sharp_length_mm);
    EXPECT_LT(after.normal_variation_rms, before.normal_variation_rms);
    std::cout << "h " << h << ": " << report->smooth.swaps << " and " << report->feature.swaps << " swaps, p5 "
              << report->smooth.angle_p5_before_deg << " " << report->smooth.angle_p5_after_deg << " " << p5
              << " deg, dihedral sum " << before.dihedral_sum_deg << " -> " << after.dihedral_sum_deg
              << ", sharp edges " << before.sharp_edges << " -> " << after.sharp_edges << "\n";
  }
  return mesh;
}

class OptimisedDemo : public testing::TestWithParam<const char*> {};

TEST_P(OptimisedDemo, IsSoundAndNearerToTheSolidAtItsEdges) {
  const std::string name = GetParam();
  const Workers workers;
  const auto object = simulate::make_object(name);
  ASSERT_TRUE(object.ok());
  const MemoryPoints points(simulate::measured_points(**object, simulate::demo_plan(name), workers.context()));
  const double nominal = name == "handset" ? 2 : 1;
  for (const double h : {nominal, nominal / 2}) {
    SCOPED_TRACE(h);
    const Mesh start = mesh_of(points, h, workers.context());
    ASSERT_FALSE(start.triangles.empty());
    EXPECT_EQ(crossings(start, 2.5 * h), 0u);
    const Mesh smooth = optimised(start, false, h, workers.context());
    const Mesh both = optimised(start, true, h, workers.context());
    const bool sharp = name == "handset";
    const double before = rms_off(smooth, **object, h, sharp), after = rms_off(both, **object, h, sharp);
    std::cout << name << " h " << h << (sharp ? ": rms near edges " : ": rms ") << before << " -> " << after << " mm\n";
    EXPECT_LT(after, sharp ? 0.95 * before : 1.01 * before);
  }
}

INSTANTIATE_TEST_SUITE_P(Solids, OptimisedDemo, testing::Values("figurine", "handset"),
                         [](const auto& test) { return std::string(test.param); });

TEST(OptimisedBunny, IsSound) {
  const std::string data = support::data_folder();
  if (data.empty() || !std::filesystem::is_directory(data + "/range-views/bunny"))
    GTEST_SKIP() << "no range-views/bunny";
  const std::string archive = data + "/range-views/bunny";
  const Workers workers;
  const auto found = pipeline::discover(archive, false);
  ASSERT_TRUE(found.ok()) << found.error().text();
  const auto points = pipeline::ScanPoints::open(archive, found->scans.front(), 1000);
  ASSERT_TRUE(points.ok()) << points.error().text();
  const Mesh start = mesh_of(**points, 1, workers.context());
  ASSERT_FALSE(start.triangles.empty());
  optimised(start, false, 1, workers.context());
  optimised(start, true, 1, workers.context());
}

}  // namespace
}  // namespace scanmill
