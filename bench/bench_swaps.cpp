// SPDX-License-Identifier: Apache-2.0
// How many edges per CPU second do the two passes of edge swaps take?
//   bench_swaps [FILE.stl --bin H] [--edges N] [--threads N] [--repeat R] [--json] [--stl OUT]
// With a binary STL: its mesh, as `scanmill mesh` writes it, range 2.5 H. Without: a rough torus of N edges (default
// 1,000,000) whose diagonals were drawn by lot from a fixed seed. Every repetition must give the same mesh with the
// same topology; medians are printed. "Per second": edges of the mesh over CPU seconds of the pass; an edge counts once
// however often it is judged. "Prepare" is what both passes share, "whole" is optimise() with its reports.
#include <sys/resource.h>

#include <algorithm>
#include <bit>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <map>
#include <string>

#include "base/random.hpp"
#include "export/writers.hpp"
#include "mesh/limits.hpp"
#include "optimise/feature.hpp"
#include "optimise/optimise.hpp"
#include "optimise/rounds.hpp"
#include "optimise/smooth.hpp"
#include "store/files.hpp"

namespace {

using namespace scanmill;

double cpu_seconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
         1e-6 * static_cast<double>(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec);
}

double peak_mib() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values.empty() ? 0 : values[values.size() / 2];
}

struct Options {
  std::string file, stl;
  double bin = 0;
  std::size_t edges = 1000000;
  int threads = 1, repeat = 5;
  bool json = false;
};

int usage() {
  std::fputs("bench_swaps [FILE.stl --bin H] [--edges N] [--threads N] [--repeat R] [--json] [--stl OUT]\n", stderr);
  return 2;
}

bool parse(int argc, char** argv, Options& options) {
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--json") {
      options.json = true;
    } else if (word.starts_with("--")) {
      if (i + 1 == argc) return false;
      const std::string value = argv[++i];
      if (word == "--bin")
        options.bin = std::atof(value.c_str());
      else if (word == "--edges")
        options.edges = static_cast<std::size_t>(std::atof(value.c_str()));
      else if (word == "--threads")
        options.threads = std::max(1, std::atoi(value.c_str()));
      else if (word == "--repeat")
        options.repeat = std::max(1, std::atoi(value.c_str()));
      else if (word == "--stl")
        options.stl = value;
      else
        return false;
    } else {
      options.file = word;
    }
  }
  return options.file.empty() || options.bin > 0;
}

void to_convention(Mesh& mesh) {
  for (Triangle& t : mesh.triangles) std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
  std::sort(mesh.triangles.begin(), mesh.triangles.end());
}

/// Corners with the same coordinates are one vertex, numbered as they come. Empty when the file is no binary STL.
Mesh read_stl(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(in), {}};
  Mesh mesh;
  if (bytes.size() < 84) return mesh;
  std::uint32_t count;
  std::memcpy(&count, bytes.data() + 80, 4);
  if (bytes.size() != 84 + 50 * static_cast<std::size_t>(count)) return mesh;
  struct Corner {
    float x, y, z;
    std::uint32_t number;
    auto place() const { return std::tuple(x, y, z); }
  };
  std::vector<Corner> corners(3 * static_cast<std::size_t>(count));
  for (std::size_t i = 0; i < corners.size(); ++i) {
    std::memcpy(&corners[i], bytes.data() + 84 + 50 * (i / 3) + 12 + 12 * (i % 3), 12);
    corners[i].number = static_cast<std::uint32_t>(i);
  }
  std::sort(corners.begin(), corners.end(), [](const Corner& a, const Corner& b) {
    return a.place() != b.place() ? a.place() < b.place() : a.number < b.number;
  });
  std::vector<std::uint32_t> first(corners.size()), row(corners.size());
  for (std::size_t i = 0; i < corners.size(); ++i)
    first[corners[i].number] =
        i > 0 && corners[i].place() == corners[i - 1].place() ? first[corners[i - 1].number] : corners[i].number;
  std::vector<Vec3> at(corners.size());
  for (const Corner& c : corners)
    at[c.number] = {static_cast<double>(c.x), static_cast<double>(c.y), static_cast<double>(c.z)};
  mesh.triangles.resize(count);
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (first[i] == i) {
      row[i] = static_cast<std::uint32_t>(mesh.positions.size());
      mesh.positions.push_back(at[i]);
    }
    mesh.triangles[i / 3][i % 3] = row[first[i]];
  }
  to_convention(mesh);
  return mesh;
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
  to_convention(mesh);
  return mesh;
}

int failed(const Error& error) {
  std::fprintf(stderr, "bench_swaps: %s\n", error.text().c_str());
  return 1;
}

struct Figures {
  std::map<std::string, std::vector<double>> cpu, wall;
  optimise::PassReport smooth, feature;
};

/// The steps of optimise() one by one, on the clock.
Result<void> time_steps(const Mesh& mesh, const optimise::Limits& limits, const Context& context, Figures& figures) {
  using namespace optimise;
  double cpu = 0;
  std::chrono::steady_clock::time_point began;
  auto start = [&] {
    cpu = cpu_seconds();
    began = std::chrono::steady_clock::now();
  };
  auto stop = [&](const char* step) {
    figures.cpu[step].push_back(cpu_seconds() - cpu);
    figures.wall[step].push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count());
  };
  start();
  Surface surface(mesh);
  NearVertices near(surface, limits.range_mm);
  stop("prepare");
  figures.smooth = figures.feature = {};
  start();
  SmoothRule smooth(surface);
  TRY(run_rounds(surface, smooth, near, limits, context, figures.smooth));
  stop("smooth");
  start();
  FeatureRule feature(surface, context);
  TRY(run_rounds(surface, feature, near, limits, context, figures.feature));
  stop("feature");
  return {};
}

void print(const Options& options, const Figures& figures, std::uint64_t edges, const optimise::Report& report) {
  auto rate = [&](const char* step) { return static_cast<double>(edges) / median(figures.cpu.at(step)) / 1e6; };
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
  for (const auto& [step, times] : figures.cpu)
    std::printf(options.json ? ",\"%s_cpu_s\":%.4f,\"%s_wall_s\":%.4f" : "  %-8s %.4f CPU s, %s %.4f s wall\n",
                step.c_str(), median(times), options.json ? step.c_str() : "", median(figures.wall.at(step)));
  std::printf(options.json ? "}\n" : "");
}

int run(const Options& options) {
  const ChunkLoop loop(options.threads);
  const CancelFlag cancel;
  const Context context{loop, cancel};
  const Mesh mesh = options.file.empty() ? make_torus(options.edges) : read_stl(options.file);
  if (mesh.triangles.empty()) return failed(fail(Code::BadInput, "no binary STL with triangles", options.file));
  const double longest = options.file.empty() ? 2.5 : 2.5 * options.bin;
  const optimise::Limits limits{longest, cos_of_degrees(5)};
  const TopologyCounts before = topology_of(mesh);
  Figures figures;
  Mesh first;
  optimise::Report report;
  for (int n = 0; n < options.repeat; ++n) {
    if (const auto timed = time_steps(mesh, limits, context, figures); !timed) return failed(timed.error());
    Mesh swapped = mesh;
    const double cpu = cpu_seconds();
    const auto began = std::chrono::steady_clock::now();
    auto done = optimise::optimise(swapped, {}, limits, context);
    if (!done) return failed(done.error());
    figures.cpu["whole"].push_back(cpu_seconds() - cpu);
    figures.wall["whole"].push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count());
    if (n > 0 && swapped.triangles != first.triangles) return failed(fail(Code::Internal, "two runs gave two meshes"));
    report = *done;
    first = std::move(swapped);
  }
  const TopologyCounts after = topology_of(first);
  if (after.edges != before.edges || after.boundary_loops != before.boundary_loops || after.euler != before.euler ||
      after.nonmanifold_edges != before.nonmanifold_edges || after.components != before.components ||
      after.nonmanifold_vertices != before.nonmanifold_vertices || after.misoriented_edges != before.misoriented_edges)
    return failed(fail(Code::Internal, "the swaps changed the topology"));
  if (!options.stl.empty()) {
    auto sink = store::create_file(options.stl);
    if (!sink) return failed(sink.error());
    if (auto written = exporting::write_stl(first, **sink); !written) return failed(written.error());
    if (auto written = (*sink)->commit(); !written) return failed(written.error());
  }
  print(options, figures, before.edges, report);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  if (!parse(argc, argv, options)) return usage();
  return run(options);
}
