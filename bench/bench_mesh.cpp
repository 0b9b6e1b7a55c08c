// SPDX-License-Identifier: Apache-2.0
// How fast do kept points become a mesh, and where does the time go?
//   bench_mesh FILE.ply --bin H [--threads N] [--repeat R] [--engine stars|front] [--profile scan|paper] [--json]
//              [--stl OUT] [--kept OUT.ply] [--rivals DIR]
// The mesh of every repetition must be the same and sound; medians of CPU seconds are printed. --rivals runs
// DIR/cgal_mesh --method advancing_front on the kept points in between, so that both meet the same machine.
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <map>
#include <string>

#include "bench/measure.hpp"
#include "export/writers.hpp"
#include "pipeline/surface.hpp"

namespace {

using namespace scanmill;
using namespace scanmill::bench;

/// CPU seconds from one announced stage to the next.
class StageClock final : public Progress {
 public:
  void stage(std::string_view name, std::uint64_t, std::uint64_t) override {
    stop();
    running_ = name;
    since_ = cpu_seconds();
  }
  void stop() {
    if (!running_.empty()) spent[running_] += cpu_seconds() - since_;
    running_.clear();
  }
  std::map<std::string, double> spent;

 private:
  std::string running_;
  double since_ = 0;
};

struct Options : CommandLine {
  std::string rivals, stl, kept;
  pipeline::What what;
};

int usage() {
  std::fputs(
      "bench_mesh FILE.ply --bin H [--threads N] [--repeat R] [--engine stars|front] [--profile scan|paper] [--json] "
      "[--stl OUT] [--kept OUT.ply] [--rivals DIR]\n",
      stderr);
  return 2;
}

bool parse_options(int argc, char** argv, Options& o) {
  const auto engine = [&](const std::string& value) {
    o.what.grow.engine = value == "front" ? Engine::Front : Engine::Stars;
    return value == "front" || value == "stars";
  };
  const auto profile = [&](const std::string& value) {
    if (value == "paper") {
      o.what.reduce = reduce::Params::paper();
      o.what.grow.range_bins = 2;
      o.what.lattice.origin = reduce::Origin::Bounds;
    }
    return value == "paper" || value == "scan";
  };
  return o.parse(argc, argv,
                 {{"--bin", number_into(o.what.lattice.bin_mm)},
                  {"--engine", engine},
                  {"--profile", profile},
                  {"--stl", text_into(o.stl)},
                  {"--kept", text_into(o.kept)},
                  {"--rivals", text_into(o.rivals)}}) &&
         !o.file.empty() && o.what.lattice.bin_mm.has_value();
}

std::size_t write_kept(const reduce::ReducedCloud& cloud, const std::string& file) {
  std::vector<float> values;
  for (std::size_t row = 0; row < cloud.size(); ++row) {
    if (cloud.drop[row] != reduce::Drop::Kept) continue;
    const Vec3 p = cloud.measured[row];
    for (const double c : {p.x, p.y, p.z}) values.push_back(static_cast<float>(c));
  }
  std::ofstream out(file, std::ios::binary);
  out << "ply\nformat binary_little_endian 1.0\nelement vertex " << values.size() / 3
      << "\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
  out.write(reinterpret_cast<const char*>(values.data()), static_cast<std::streamsize>(values.size() * sizeof(float)));
  return values.size() / 3;
}

/// CPU seconds the rival says its computing took (reading and writing apart); negative when it failed.
double run_rival(const std::string& folder, const std::string& kept) {
  const std::string command =
      "'" + folder + "/cgal_mesh' --method advancing_front --in '" + kept + "' --out '" + kept + ".rival.ply'";
  std::FILE* pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) return -1;
  std::string said;
  for (int c = std::fgetc(pipe); c != EOF; c = std::fgetc(pipe)) said += static_cast<char>(c);
  const std::string key = "\"compute_cpu_s\":";
  const std::size_t at = said.find(key);
  return pclose(pipe) == 0 && at != std::string::npos ? std::atof(said.c_str() + at + key.size()) : -1;
}

Result<void> write_stl(const Mesh& mesh, const std::string& file) {
  TRY_ASSIGN(const auto sink, store::create_file(file));
  TRY(exporting::write_stl(mesh, *sink));
  return sink->commit();
}

void print(const Options& options, const pipeline::MeshedSurface& mesh, std::size_t kept, double reduce_cpu,
           const std::map<std::string, std::vector<double>>& stages, double wall, double rival) {
  double cpu = 0;
  for (const auto& [name, times] : stages) cpu += median(times);
  const TopologyCounts counts = topology_of(mesh.mesh);
  const double rate = static_cast<double>(kept) / cpu;
  const char* line =
      options.json
          ? "{\"type\":\"bench_mesh\",\"kept\":%zu,\"used\":%llu,\"triangles\":%llu,\"boundary_edges\":%llu,"
            "\"loops\":%llu,\"components\":%llu,\"patches\":%zu,\"mesh_cpu_s\":%.4f,\"wall_s\":%.4f,"
            "\"kept_per_cpu_s\":%.0f,\"reduce_cpu_s\":%.4f,\"peak_mib\":%.0f"
          : "kept %zu, used %llu, triangles %llu, boundary edges %llu in %llu loops, components %llu, patches %zu\n"
            "mesh %.4f CPU s, %.4f s wall, %.0f kept points per CPU s; reduce %.4f CPU s; peak %.0f MiB\n";
  std::printf(line, kept, static_cast<unsigned long long>(mesh.kept_used),
              static_cast<unsigned long long>(counts.triangles), static_cast<unsigned long long>(counts.boundary_edges),
              static_cast<unsigned long long>(counts.boundary_loops),
              static_cast<unsigned long long>(counts.components), mesh.patches.patches.size(), cpu, wall, rate,
              reduce_cpu, peak_mib());
  for (const auto& [name, times] : stages)
    std::printf(options.json ? ",\"%s_cpu_s\":%.4f" : "  %-6s %.4f CPU s\n", name.c_str(), median(times));
  if (rival > 0)
    std::printf(options.json ? ",\"advancing_front_cpu_s\":%.4f,\"ratio\":%.2f"
                             : "advancing front %.4f CPU s, %.2f times ours\n",
                rival, rival / cpu);
  std::printf(options.json ? "}\n" : "");
}

Result<void> run(const Options& options) {
  const ChunkLoop loop(options.threads);
  const CancelFlag cancel;
  const Context context{loop, cancel};
  TRY_ASSIGN(auto points, read_points(options.file));
  const MemoryPoints source(std::move(points));
  const double start = cpu_seconds();
  TRY_ASSIGN(const auto reduced, reduce::reduce_cloud(source, options.what.lattice, options.what.reduce, context));
  const double reduce_cpu = cpu_seconds() - start;
  const std::string kept_file = !options.kept.empty() ? options.kept : options.file + ".kept.ply";
  std::size_t kept = reduced.report.kept;
  if (!options.rivals.empty() || !options.kept.empty()) kept = write_kept(reduced.cloud, kept_file);
  std::map<std::string, std::vector<double>> stages;
  std::vector<double> walls, rivals;
  std::optional<pipeline::MeshedSurface> first;
  for (int n = 0; n < options.repeat; ++n) {
    StageClock clock;
    const double began = wall_seconds();
    TRY_ASSIGN(auto mesh, pipeline::mesh_surface(reduced.cloud, reduced.report.bounds, options.what, context, clock));
    walls.push_back(wall_seconds() - began);
    clock.stop();
    for (const auto& [name, spent] : clock.spent) stages[name].push_back(spent);
    if (first && first->mesh.triangles != mesh.mesh.triangles) return fail(Code::Internal, "two runs gave two meshes");
    if (!first) first = std::move(mesh);
    if (!options.rivals.empty()) rivals.push_back(run_rival(options.rivals, kept_file));
  }
  const TopologyCounts counts = topology_of(first->mesh);
  if (counts.nonmanifold_edges + counts.nonmanifold_vertices + counts.misoriented_edges > 0)
    return fail(Code::Internal, "the mesh is not an oriented manifold");
  if (!options.stl.empty()) TRY(write_stl(first->mesh, options.stl));
  print(options, *first, kept, reduce_cpu, stages, median(walls), median(rivals));
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  return parse_options(argc, argv, options) ? exit_code("bench_mesh", run(options)) : usage();
}
