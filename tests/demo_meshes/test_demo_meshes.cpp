// SPDX-License-Identifier: Apache-2.0
// How far the meshes of the demo solids are from the solids they were scanned from.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "base/random.hpp"
#include "cloud/cloud.hpp"
#include "pipeline/surface.hpp"
#include "simulate/demo_plans.hpp"

namespace scanmill {
namespace {

constexpr double kSigma = 0.025;  // of the demo plans' sensor, mm
constexpr std::size_t kSamples = 60000;

double point_triangle(Vec3 p, Vec3 a, Vec3 b,
                      Vec3 c) {  // by regions of the plane (Ericson, Real-Time Collision Detection, 5.1.5)
  const Vec3 ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
  const double d1 = dot(ab, ap), d2 = dot(ac, ap), d3 = dot(ab, bp), d4 = dot(ac, bp), d5 = dot(ab, cp),
               d6 = dot(ac, cp);
  if (d1 <= 0 && d2 <= 0) return norm(ap);
  if (d3 >= 0 && d4 <= d3) return norm(bp);
  if (d6 >= 0 && d5 <= d6) return norm(cp);
  const double vc = d1 * d4 - d3 * d2, vb = d5 * d2 - d1 * d6, va = d3 * d6 - d5 * d4;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return norm(ap - ab * (d1 / (d1 - d3)));
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return norm(ap - ac * (d2 / (d2 - d6)));
  if (va <= 0 && d4 >= d3 && d5 >= d6) return norm(bp - (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6))));
  return norm(ap - ab * (vb / (va + vb + vc)) - ac * (vc / (va + vb + vc)));
}

/// Distances to the nearest triangle, by cells wider than any triangle.
class NearestTriangle {
 public:
  NearestTriangle(const Mesh& mesh, double cell) : mesh_(mesh), cell_(cell) {
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
      Bounds box;
      for (const std::uint32_t v : mesh.triangles[t]) box.add(mesh.positions[v]);
      const auto low = cell_of(box.low), high = cell_of(box.high);
      for (int x = low[0]; x <= high[0]; ++x)
        for (int y = low[1]; y <= high[1]; ++y)
          for (int z = low[2]; z <= high[2]; ++z) cells_[{x, y, z}].push_back(t);
    }
  }
  double operator()(Vec3 p) const {
    double best = 1e9;
    const auto at = cell_of(p);
    for (int x = -1; x <= 1; ++x)
      for (int y = -1; y <= 1; ++y)
        for (int z = -1; z <= 1; ++z) {
          const auto found = cells_.find({at[0] + x, at[1] + y, at[2] + z});
          if (found == cells_.end()) continue;
          for (const std::uint32_t t : found->second) {
            const Triangle& k = mesh_.triangles[t];
            best =
                std::min(best, point_triangle(p, mesh_.positions[k[0]], mesh_.positions[k[1]], mesh_.positions[k[2]]));
          }
        }
    return best;
  }

 private:
  std::array<int, 3> cell_of(Vec3 p) const {
    return {static_cast<int>(std::floor(p.x / cell_)), static_cast<int>(std::floor(p.y / cell_)),
            static_cast<int>(std::floor(p.z / cell_))};
  }
  const Mesh& mesh_;
  double cell_;
  std::map<std::array<int, 3>, std::vector<std::uint32_t>> cells_;
};

std::vector<Vec3> samples_of(const Mesh& mesh) {
  std::vector<double> area(1, 0);
  for (const Triangle& t : mesh.triangles)
    area.push_back(area.back() + norm(cross(mesh.positions[t[1]] - mesh.positions[t[0]],
                                            mesh.positions[t[2]] - mesh.positions[t[0]])));
  Random random(1, 2, 3);
  std::vector<Vec3> samples;
  for (std::size_t i = 0; i < kSamples; ++i) {
    const auto at = std::upper_bound(area.begin(), area.end(), random.uniform() * area.back()) - area.begin() - 1;
    const Triangle& t = mesh.triangles[std::min(static_cast<std::size_t>(at), mesh.triangles.size() - 1)];
    const double r = std::sqrt(random.uniform()), s = random.uniform();
    samples.push_back(mesh.positions[t[0]] * (1 - r) + mesh.positions[t[1]] * (r * (1 - s)) +
                      mesh.positions[t[2]] * (r * s));
  }
  return samples;
}

struct Fit {
  double rms = 0, p999 = 0;
};
Fit fit_of(std::vector<double> distance) {
  Fit fit;
  for (const double d : distance) fit.rms += d * d;
  fit.rms = std::sqrt(fit.rms / static_cast<double>(distance.size()));
  std::sort(distance.begin(), distance.end());
  fit.p999 = distance[distance.size() * 999 / 1000];
  return fit;
}

class DemoMesh : public testing::TestWithParam<const char*> {};

TEST_P(DemoMesh, FitsTheSolidAndIsOpenAtTheUnseenBottomOnly) {
  const std::string name = GetParam();
  const auto object = simulate::make_object(name);
  ASSERT_TRUE(object.ok());
  const ChunkLoop loop(2);
  const CancelFlag cancel;
  const Context context{loop, cancel};
  const MemoryPoints points(simulate::measured_points(**object, simulate::demo_plan(name), context));
  const std::vector<Vec3> seen = simulate::seen_samples(**object, kSamples, 7);
  const bool sharp = name == "handset";
  const double nominal = sharp ? 2.0 : 1.0;
  for (const pipeline::Profile profile : {pipeline::Profile::Scan, pipeline::Profile::Paper})
    for (const double h : {nominal, nominal / 2}) {
      SCOPED_TRACE(name + (profile == pipeline::Profile::Scan ? " scan" : " paper") + " at " + std::to_string(h) +
                   " mm");
      document::Node tree = document::Node::map();
      tree.set("profile", profile == pipeline::Profile::Scan ? "scan" : "paper");
      tree.set("lattice", document::Node::map()).set("bin_mm", h);
      const auto what = pipeline::what_from(tree, "test");
      ASSERT_TRUE(what.ok()) << what.error().text();
      const auto reduced = reduce::reduce_cloud(points, what->lattice, what->reduce, context);
      ASSERT_TRUE(reduced.ok()) << reduced.error().text();
      NoProgress progress;
      const auto surface = pipeline::mesh_surface(reduced->cloud, reduced->report.bounds, *what, context, progress);
      ASSERT_TRUE(surface.ok()) << surface.error().text();
      const Mesh& mesh = surface->mesh;
      const TopologyCounts counts = topology_of(mesh);
      EXPECT_EQ(counts.nonmanifold_edges + counts.nonmanifold_vertices + counts.misoriented_edges, 0u);
      EXPECT_EQ(counts.components, 1u);
      EXPECT_GT(signed_volume(mesh), 0);
      if (!sharp) {
        EXPECT_EQ(counts.boundary_edges, 0u);
      }
      for (const BorderLoop& border : surface->loops)
        for (const std::uint32_t v : border.vertices) EXPECT_LT(mesh.positions[v].z, 2.0 * h);  // the bottom is z = 0

      std::vector<double> off, far;
      for (const Vec3 p : samples_of(mesh)) off.push_back(std::abs((*object)->surface_distance(p)));
      const NearestTriangle nearest(mesh, 2.6 * h);
      for (const Vec3 p : seen) far.push_back(nearest(p));
      const Fit to_solid = fit_of(off), to_mesh = fit_of(far);
      const double share = h == nominal && profile == pipeline::Profile::Scan ? 0.14 : 0.10;
      const double rms_limit = std::sqrt(share * h * share * h + kSigma * kSigma);
      const double tail_limit = (sharp ? 1.0 : 0.75) * h + 3 * kSigma;
      EXPECT_LE(to_solid.rms, rms_limit);
      EXPECT_LE(to_mesh.rms, rms_limit);
      EXPECT_LE(to_solid.p999, tail_limit);
      EXPECT_LE(to_mesh.p999, tail_limit);
      std::cout << name << " h " << h << (profile == pipeline::Profile::Scan ? " scan" : " paper")
                << ": mesh to solid rms " << to_solid.rms / h << " h, p99.9 " << to_solid.p999 / h
                << " h; solid to mesh rms " << to_mesh.rms / h << " h, p99.9 " << to_mesh.p999 / h << " h; open edges "
                << counts.boundary_edges << "\n";
    }
}

INSTANTIATE_TEST_SUITE_P(Solids, DemoMesh, testing::Values("figurine", "handset"),
                         [](const auto& test) { return std::string(test.param); });

}  // namespace
}  // namespace scanmill
