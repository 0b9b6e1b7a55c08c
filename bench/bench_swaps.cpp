// SPDX-License-Identifier: Apache-2.0
// How many edges per CPU second do the two passes of edge swaps take?
//   bench_swaps [MESH --bin H] [--edges N] [--threads N] [--repeat R] [--json] [--stl OUT]
// With a file: its mesh, as `scanmill mesh` writes it, range 2.5 H. Without: a rough torus of N edges (default
// 1,000,000) whose diagonals were drawn by lot from a fixed seed. Every repetition must give the same mesh with the
// same topology; medians are printed. "Per second": edges of the mesh over CPU seconds of the pass; an edge counts once
// however often it is judged. "Prepare" is what both passes share, "whole" is optimise() with its reports.
#include <algorithm>
#include <cstdio>
#include <map>
#include <string>

#include "base/random.hpp"
#include "bench/measure.hpp"
#include "export/writers.hpp"
#include "mesh/limits.hpp"
#include "optimise/feature.hpp"
#include "optimise/optimise.hpp"
#include "optimise/rounds.hpp"
#include "optimise/smooth.hpp"

namespace {

using namespace scanmill;
using namespace scanmill::bench;

struct Options : CommandLine {
  std::string stl;
  double bin = 0;
  std::size_t edges = 1000000;
};

int usage() {
  std::fputs("bench_swaps [FILE.stl --bin H] [--edges N] [--threads N] [--repeat R] [--json] [--stl OUT]\n", stderr);
  return 2;
}

bool parse_options(int argc, char** argv, Options& o) {
  return o.parse(argc, argv,
                 {{"--bin", number_into(o.bin)}, {"--edges", number_into(o.edges)}, {"--stl", text_into(o.stl)}}) &&
         (o.file.empty() || o.bin > 0);
}

void to_convention(Mesh& mesh) {
  for (Triangle& t : mesh.triangles) std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
  std::sort(mesh.triangles.begin(), mesh.triangles.end());
}

/// A ring of quadrilaterals of about 1 mm, rough by a tenth of it, each with a diagonal drawn by lot. The tube is thin
/// against the ring, so that the quadrilaterals are nearly alike inside and outside.
Mesh make_torus(std::size_t edges) {
  const auto around = static_cast<std::uint32_t>(std::sqrt(static_cast<double>(edges) / 30)), along = 10 * around;
  const double tube = around / 6.2831853, ring = along / 6.2831853;
  Random random(1, 2, 3);
  Mesh mesh;
  for (std::uint32_t i = 0; i < along; ++i)
    for (std::uint32_t j = 0; j < around; ++j) {
      const double u = 360 * (i + 0.3 * random.uniform()) / along, v = 360 * (j + 0.3 * random.uniform()) / around;
      const double r = tube + 0.1 * random.uniform(), w = ring + r * cos_of_degrees(v);
      const Vec3 p{w * cos_of_degrees(u), w * cos_of_degrees(90 - u), r * cos_of_degrees(90 - v)};
      auto cut = [](double x) { return static_cast<double>(static_cast<float>(x)); };
      mesh.positions.push_back({cut(p.x), cut(p.y), cut(p.z)});
    }
  for (std::uint32_t i = 0; i < along; ++i)
    for (std::uint32_t j = 0; j < around; ++j) {
      const std::uint32_t next_i = (i + 1) % along, next_j = (j + 1) % around;
      const std::uint32_t a = i * around + j, b = next_i * around + j, c = next_i * around + next_j,
                          d = i * around + next_j;
      if (random.uniform() < 0.5)
        mesh.triangles.insert(mesh.triangles.end(), {{a, b, c}, {a, c, d}});
      else
        mesh.triangles.insert(mesh.triangles.end(), {{a, b, d}, {b, c, d}});
    }
  return mesh;
}

struct Figures {
  std::map<std::string, Timing> steps;
  optimise::PassReport smooth, feature;
};

/// The steps of optimise() one by one, on the clock.
Result<void> time_steps(const Mesh& mesh, const optimise::Limits& limits, const Context& context, Figures& figures) {
  using namespace optimise;
  auto start = [&](const char* step) { figures.steps[step].start(); };
  auto stop = [&](const char* step) { figures.steps[step].stop(); };
  start("prepare");
  Surface surface(mesh);
  NearVertices near(surface, limits.range_mm);
  stop("prepare");
  figures.smooth = figures.feature = {};
  start("smooth");
  SmoothRule smooth(surface);
  TRY(run_rounds(surface, smooth, near, limits, context, figures.smooth));
  stop("smooth");
  start("feature");
  FeatureRule feature(surface, context);
  TRY(run_rounds(surface, feature, near, limits, context, figures.feature));
  stop("feature");
  return {};
}

void print(const Options& options, const Figures& figures, std::uint64_t edges, const optimise::Report& report) {
  auto rate = [&](const char* step) { return static_cast<double>(edges) / figures.steps.at(step).cpu() / 1e6; };
  const auto number = [](std::uint64_t n) { return static_cast<unsigned long long>(n); };
  std::printf(
      options.json ? "{\"type\":\"bench_swaps\",\"edges\":%llu,\"threads\":%d,\"peak_mib\":%.0f,"
                     "\"smooth_m_edges_per_cpu_s\":%.2f,\"smooth_rounds\":%llu,\"smooth_swaps\":%llu,"
                     "\"feature_m_edges_per_cpu_s\":%.2f,\"feature_rounds\":%llu,\"feature_swaps\":%llu,"
                     "\"angle_p5_deg\":[%.2f,%.2f,%.2f],\"dihedral_sum_deg\":[%.0f,%.0f]"
                   : "edges %llu, threads %d, peak %.0f MiB\n"
                     "smooth  %.2f M edges per CPU second, %llu rounds, %llu swaps\n"
                     "feature %.2f M edges per CPU second, %llu rounds, %llu swaps\n"
                     "smallest angle, 5th percentile: %.2f, %.2f, %.2f degrees; sum of dihedral angles %.0f, %.0f\n",
      number(edges), options.threads, peak_mib(), rate("smooth"), number(figures.smooth.rounds),
      number(figures.smooth.swaps), rate("feature"), number(figures.feature.rounds), number(figures.feature.swaps),
      report.smooth.angle_p5_before_deg, report.smooth.angle_p5_after_deg, report.feature.angle_p5_after_deg,
      report.before_feature.dihedral_sum_deg, report.after_feature.dihedral_sum_deg);
  for (const auto& [step, timing] : figures.steps)
    std::printf(options.json ? ",\"%s_cpu_s\":%.4f,\"%s_wall_s\":%.4f" : "  %-8s %.4f CPU s, %s %.4f s wall\n",
                step.c_str(), timing.cpu(), options.json ? step.c_str() : "", timing.wall());
  std::printf(options.json ? "}\n" : "");
}

Result<void> run(const Options& options) {
  const ChunkLoop loop(options.threads);
  const CancelFlag cancel;
  const Context context{loop, cancel};
  Mesh mesh;
  if (options.file.empty())
    mesh = make_torus(options.edges);
  else {
    TRY_ASSIGN(mesh, read_mesh(options.file));
  }
  to_convention(mesh);
  const double longest = options.file.empty() ? 2.5 : 2.5 * options.bin;
  const optimise::Limits limits{longest, cos_of_degrees(5)};
  const TopologyCounts before = topology_of(mesh);
  Figures figures;
  Mesh first;
  optimise::Report report;
  for (int n = 0; n < options.repeat; ++n) {
    TRY(time_steps(mesh, limits, context, figures));
    Mesh swapped = mesh;
    figures.steps["whole"].start();
    TRY_ASSIGN(report, optimise::optimise(swapped, {}, limits, context));
    figures.steps["whole"].stop();
    if (n > 0 && swapped.triangles != first.triangles) return fail(Code::Internal, "two runs gave two meshes");
    first = std::move(swapped);
  }
  const TopologyCounts after = topology_of(first);
  if (after.edges != before.edges || after.boundary_loops != before.boundary_loops || after.euler != before.euler ||
      after.nonmanifold_edges != before.nonmanifold_edges || after.components != before.components ||
      after.nonmanifold_vertices != before.nonmanifold_vertices || after.misoriented_edges != before.misoriented_edges)
    return fail(Code::Internal, "the swaps changed the topology");
  if (!options.stl.empty()) {
    TRY_ASSIGN(const auto sink, store::create_file(options.stl));
    TRY(exporting::write_stl(first, *sink));
    TRY(sink->commit());
  }
  print(options, figures, before.edges, report);
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  return parse_options(argc, argv, options) ? exit_code("bench_swaps", run(options)) : usage();
}
