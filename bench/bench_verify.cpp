// SPDX-License-Identifier: Apache-2.0
// How fast is a mesh judged against every point of its cloud, and by itself?
//   bench_verify FILE.ply --bin H [--mesh FILE] [--threads N] [--repeat R] [--json]
// Without --mesh the cloud is reduced and meshed first (not timed), and errors per vertex are part of the work. Every
// repetition must find the same; medians of CPU and wall seconds are printed, with what was found.
#include <cstdio>
#include <string>

#include "bench/measure.hpp"
#include "pipeline/surface.hpp"
#include "verify/verify.hpp"

namespace {

using namespace scanmill;
using namespace scanmill::bench;

struct Options : CommandLine {
  std::string mesh;
  pipeline::What what;
};

int usage() {
  std::fputs("bench_verify FILE.ply --bin H [--mesh FILE] [--threads N] [--repeat R] [--json]\n", stderr);
  return 2;
}

bool parse_options(int argc, char** argv, Options& o) {
  return o.parse(argc, argv, {{"--bin", number_into(o.what.lattice.bin_mm)}, {"--mesh", text_into(o.mesh)}}) &&
         !o.file.empty() && o.what.lattice.bin_mm.has_value();
}

/// What is judged.
struct Subject {
  Mesh mesh;
  std::optional<reduce::Reduction> reduction;
  std::vector<std::uint32_t> vertex_of_row;
  verify::Terms terms;
};

Result<void> make_subject(const Options& options, const PointSource& points, const Context& context, Subject& subject) {
  subject.terms.bin_mm = *options.what.lattice.bin_mm;
  if (!options.mesh.empty()) {
    TRY_ASSIGN(subject.mesh, read_mesh(options.mesh));
    return {};
  }
  NoProgress silent;
  TRY_ASSIGN(subject.reduction, reduce::reduce_cloud(points, options.what.lattice, options.what.reduce, context));
  const auto& cloud = subject.reduction->cloud;
  TRY_ASSIGN(auto surface,
             pipeline::mesh_surface(cloud, subject.reduction->report.bounds, options.what, context, silent));
  subject.mesh = std::move(surface.mesh);
  subject.vertex_of_row.assign(cloud.size(), verify::kNoVertex);
  for (std::uint32_t v = 0; v < surface.vertex_row.size(); ++v) subject.vertex_of_row[surface.vertex_row[v]] = v;
  subject.terms.vertex_bins = verify::VertexBins{cloud.lattice, cloud.base, &cloud.index, subject.vertex_of_row};
  return {};
}

struct Times {
  Timing quality, verify;
};

void print_quality(const verify::Quality& q) {
  const TopologyCounts& t = q.topology;
  const auto n = [](const char* name, std::uint64_t value) {
    std::printf(",\"%s\":%llu", name, static_cast<unsigned long long>(value));
  };
  n("vertices", t.vertices_used);
  n("triangles", t.triangles);
  n("edges", t.edges);
  n("boundary_edges", t.boundary_edges);
  n("boundary_loops", t.boundary_loops);
  n("nonmanifold_edges", t.nonmanifold_edges);
  n("nonmanifold_vertices", t.nonmanifold_vertices);
  n("index_degenerate_faces", q.repeated_corners);
  n("duplicate_faces", q.duplicate_triangles);
  n("components", t.components);
  n("edge_components", q.edge_components);
  n("inconsistent_edges", t.misoriented_edges);
  n("zero_area_faces", q.zero_area_triangles);
  n("self_intersecting_pairs", q.crossing_pairs);
  n("self_intersecting_faces", q.crossing_triangles);
  n("orientable", q.orientable);
  n("closed_manifold", q.closed_manifold);
  std::printf(",\"euler\":%lld,\"largest_component_share\":%.9g,\"area\":%.12g,\"signed_volume\":%.12g",
              static_cast<long long>(t.euler), q.largest_component_share, q.area_mm2, q.volume_mm3);
  std::printf(",\"min_angle_min\":%.9g,\"min_angle_p1\":%.9g,\"min_angle_p5\":%.9g,\"min_angle_p50\":%.9g",
              q.angles.least, q.angles.p1, q.angles.p5, q.angles.p50);
  std::printf(",\"min_angle_mean\":%.9g,\"edge_p50\":%.9g,\"edge_p99\":%.9g,\"edge_max\":%.9g", q.angles.mean,
              q.edges.p50, q.edges.p99, q.edges.greatest);
}

void print(const Options& options, const verify::Quality& q, const verify::Report& r, const Times& times) {
  const double cpu = times.verify.cpu(), quality = times.quality.cpu();
  const double rate = static_cast<double>(r.all.count) / cpu;
  const double triangles = static_cast<double>(q.topology.triangles) / quality;
  if (!options.json) {
    std::printf("%llu points, %llu triangles, %d threads\n", static_cast<unsigned long long>(r.all.count),
                static_cast<unsigned long long>(q.topology.triangles), options.threads);
    std::printf("distances %.4f CPU s, %.4f s wall, %.0f points per CPU s: rms %.6f, p99 %.6f, max %.6f mm\n", cpu,
                times.verify.wall(), rate, r.all.rms_mm, r.all.percentiles->p99, r.all.max_mm);
    std::printf("quality %.4f CPU s, %.4f s wall, %.0f triangles per CPU s; peak %.0f MiB\n", quality,
                times.quality.wall(), triangles, peak_mib());
    return;
  }
  std::printf("{\"type\":\"bench_verify\",\"points\":%llu,\"threads\":%d,\"verify_cpu_s\":%.4f,\"verify_wall_s\":%.4f",
              static_cast<unsigned long long>(r.all.count), options.threads, cpu, times.verify.wall());
  std::printf(",\"points_per_cpu_s\":%.0f,\"quality_cpu_s\":%.4f,\"quality_wall_s\":%.4f,\"triangles_per_cpu_s\":%.0f",
              rate, quality, times.quality.wall(), triangles);
  std::printf(",\"to_mesh_mean\":%.12g,\"to_mesh_rms\":%.12g,\"to_mesh_p99\":%.12g,\"to_mesh_max\":%.12g",
              r.all.mean_mm, r.all.rms_mm, r.all.percentiles->p99, r.all.max_mm);
  std::printf(",\"open_border_points\":%llu,\"signed_mean\":%.12g,\"triangles_near\":%llu",
              static_cast<unsigned long long>(r.open_border.count), r.all.signed_mean_mm,
              static_cast<unsigned long long>(r.coverage.triangles_near));
  print_quality(q);
  std::printf(",\"peak_mib\":%.0f}\n", peak_mib());
}

Result<void> run(const Options& options) {
  const ChunkLoop loop(options.threads);
  const CancelFlag cancel;
  const Context context{loop, cancel};
  TRY_ASSIGN(auto points, read_points(options.file));
  const MemoryPoints source(std::move(points));
  Subject subject;
  TRY(make_subject(options, source, context, subject));
  Times times;
  std::optional<verify::Report> first;
  std::optional<verify::Quality> quality;
  for (int n = 0; n < options.repeat; ++n) {
    times.quality.start();
    TRY_ASSIGN(auto looks, verify::quality_of(subject.mesh, context));
    times.quality.stop();
    times.verify.start();
    TRY_ASSIGN(auto report, verify::verify_mesh(subject.mesh, source, subject.terms, {}, context));
    times.verify.stop();
    if (first && (first->all.rms_mm != report.all.rms_mm || first->all.max_mm != report.all.max_mm ||
                  quality->crossing_pairs != looks.crossing_pairs))
      return fail(Code::Internal, "two runs found two results");
    first = std::move(report);
    quality = std::move(looks);
  }
  print(options, *quality, *first, times);
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  return parse_options(argc, argv, options) ? exit_code("bench_verify", run(options)) : usage();
}
