// SPDX-License-Identifier: Apache-2.0
#include "pipeline/judge_scan.hpp"

#include <algorithm>
#include <numeric>

#include "base/text.hpp"
#include "pipeline/watched_points.hpp"

namespace scanmill::pipeline {
namespace {

/// A triangle's place in its patch by distance of its centroid from the seed, as growth gives it.
void rank_again(const Mesh& mesh, grow::Patches& patches) {
  if (patches.rank.empty()) return;
  std::vector<double> distance(mesh.triangles.size());
  for (std::size_t t = 0; t < distance.size(); ++t) {
    const Triangle& x = mesh.triangles[t];
    const Vec3 centroid = (mesh.positions[x[0]] + mesh.positions[x[1]] + mesh.positions[x[2]]) * (1.0 / 3);
    distance[t] = norm2(centroid + mesh.offset - patches.patches[mesh.patch[t]].seed);
  }
  std::vector<std::uint32_t> order(distance.size()), next(patches.patches.size(), 0);
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return distance[a] != distance[b] ? distance[a] < distance[b] : a < b;
  });
  for (const std::uint32_t t : order) patches.rank[t] = next[mesh.patch[t]]++;
}

}  // namespace

Result<optimise::Report> optimise_surface(MeshedSurface& surface, const What& what, double bin_mm,
                                          const Context& context, Progress& progress) {
  progress.stage("optimise", 0, 0);
  const optimise::Limits limits{what.grow.range_bins * bin_mm, cos_of_degrees(what.grow.min_angle_deg)};
  TRY_ASSIGN(optimise::Report report, optimise::optimise(surface.mesh, what.optimise, limits, context));
  surface.patches.patch = surface.mesh.patch;
  measure_patches(surface.mesh, surface.patches);
  rank_again(surface.mesh, surface.patches);
  return report;
}

Result<verify::Report> measure_fit(const MeshedSurface& surface, const reduce::ReducedCloud& cloud,
                                   const PointSource& points, const What& what, const Context& context,
                                   Progress& progress) {
  const WatchedPoints watched(points, "verify", progress);
  std::vector<std::uint32_t> vertex_of_row(cloud.size(), verify::kNoVertex);
  for (std::size_t v = 0; v < surface.vertex_row.size(); ++v)
    vertex_of_row[surface.vertex_row[v]] = static_cast<std::uint32_t>(v);
  verify::Terms terms;
  terms.bin_mm = cloud.lattice.edge_mm;
  terms.sensor_accuracy_mm = what.sensor.accuracy_mm;
  terms.vertex_bins = verify::VertexBins{cloud.lattice, cloud.base, &cloud.index, vertex_of_row};
  return verify::verify_mesh(surface.mesh, watched, terms, what.verify, context);
}

std::vector<std::string> failed_gates(const verify::Report& fit) {
  std::vector<std::string> list;
  for (const verify::Gate& gate : fit.gates)
    if (!gate.passed)
      list.push_back("verify." + gate.name + ": found " + number_text(gate.found) + " mm, allowed " +
                     number_text(gate.limit) + " mm");
  return list;
}

}  // namespace scanmill::pipeline
