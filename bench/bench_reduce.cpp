// SPDX-License-Identifier: Apache-2.0
// How fast is reduction, whole process: open, read, bin, frames, thin?   See bench/README.md.
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "base/context.hpp"
#include "base/random.hpp"
#include "bench/measure.hpp"
#include "pipeline/scan_points.hpp"
#include "reduce/reduce.hpp"

namespace {

using namespace scanmill;
using namespace scanmill::bench;

struct Options : CommandLine {
  std::string rivals;
  double bin_mm = 0.36;
  reduce::Params params;
};

int usage() {
  std::fputs(
      "bench_reduce [FILE] [--bin H] [--threads N] [--repeat R] [--representative centre|surface] [--json] "
      "[--rivals DIR, in a build with -DSCANMILL_RIVALS=ON]\n",
      stderr);
  return 2;
}

bool parse_options(int argc, char** argv, Options& o) {
  o.params.representative = reduce::Representative::Centre;
  const auto rule = [&](const std::string& value) {
    if (value == "surface") o.params.representative = reduce::Representative::Surface;
    return value == "centre" || value == "surface";
  };
  CommandLine::Options takes = {{"--bin", number_into(o.bin_mm)}, {"--representative", rule}};
#ifdef SCANMILL_RIVALS
  takes["--rivals"] = text_into(o.rivals);
#endif
  return o.parse(argc, argv, takes);
}

/// A million points on a sphere of 50 mm, along scan lines, 25 um noise.
std::vector<Vec3> scan_lines() {
  Random random(1, 1, 1);
  std::vector<Vec3> points;
  constexpr int kLines = 1000;
  for (int line = 0; line < kLines; ++line) {
    const double z = (line + 0.5) / kLines * 2 - 1, r = std::sqrt(1 - z * z);
    Vec3 d{1, 0, 0};
    for (int i = 0; i < kLines; ++i) {
      const double size = 50 + 0.025 * random.gauss();
      points.push_back({size * r * d.x, size * r * d.y, size * z});
      d = unit(d + Vec3{-d.y, d.x, 0} * 0.00628319);
    }
  }
  return points;
}

Result<std::unique_ptr<PointSource>> open(const Options& o) {
  if (o.file.empty()) return std::unique_ptr<PointSource>(std::make_unique<MemoryPoints>(scan_lines()));
  const std::filesystem::path path = std::filesystem::absolute(o.file);
  pipeline::ScanSpec scan;
  scan.views.resize(1);
  scan.views[0].path = path.filename().string();
  TRY_ASSIGN(auto points, pipeline::ScanPoints::open(path.parent_path().string(), scan, 1));
  return std::unique_ptr<PointSource>(std::move(points));
}

Result<reduce::Reduction> run_once(const Options& o, Timing& timing) {
  const ChunkLoop loop(o.threads);
  const CancelFlag cancel;
  timing.start();
  TRY_ASSIGN(const auto points, open(o));
  reduce::LatticeParams lattice;
  lattice.bin_mm = o.bin_mm;
  TRY_ASSIGN(auto reduction, reduce::reduce_cloud(*points, lattice, o.params, {loop, cancel}));
  timing.stop();
  return reduction;
}

Result<void> check(const reduce::Reduction& r) {
  std::uint64_t sum = 0;
  for (const std::int64_t count : r.cloud.counts) sum += static_cast<std::uint64_t>(count);
  const reduce::Report& p = r.report;
  if (sum != p.points_used || p.points_used + p.not_finite + p.sensor_invalid != p.points_read)
    return fail(Code::Internal,
                "the bins hold " + std::to_string(sum) + " points, " + std::to_string(p.points_used) + " were used");
  return {};
}

/// CPU seconds of a rival's whole process, or a negative number when it is not there or fails.
double rival_cpu(const std::string& program, const Options& o, const std::string& out) {
  if (access(program.c_str(), X_OK) != 0) return -1;
  std::fflush(stdout);
  const pid_t child = fork();
  if (child == 0) {
    const std::string leaf = std::to_string(o.bin_mm);
    if (std::freopen("/dev/null", "w", stdout) == nullptr) _exit(127);
    execl(program.c_str(), program.c_str(), "--in", o.file.c_str(), "--leaf", leaf.c_str(), "--out", out.c_str(),
          nullptr);
    _exit(127);
  }
  int status = 0;
  rusage use{};
  if (child < 0 || wait4(child, &status, 0, &use) < 0 || !WIFEXITED(status) || WEXITSTATUS(status) != 0) return -1;
  return cpu_seconds(use);
}

Result<void> run_rivals(const Options& o, double ours) {
  if (o.rivals.empty()) return {};
  if (o.file.empty()) return fail(Code::BadInput, "--rivals needs a file that all read");
  const std::string out =
      (std::filesystem::temp_directory_path() / ("bench_reduce_" + std::to_string(getpid()) + ".ply")).string();
  for (const char* name : {"pcl_reduce", "o3d_reduce", "cgal_reduce"}) {
    std::vector<double> cpu;
    for (int i = 0; i < o.repeat; ++i) cpu.push_back(rival_cpu(o.rivals + "/" + name, o, out));
    const double theirs = median(cpu);
    if (o.json)
      std::printf("{\"rival\": \"%s\", \"cpu_s\": %.4f, \"ratio\": %.3f}\n", name, theirs, theirs / ours);
    else if (theirs < 0)
      std::printf("%-12s not there, or failed\n", name);
    else
      std::printf("%-12s %.3f CPU s, %.2f of ours\n", name, theirs, theirs / ours);
  }
  std::filesystem::remove(out);
  return {};
}

void print(const Options& o, const reduce::Report& p, double cpu, double wall_s) {
  const double points = static_cast<double>(p.points_read), bins = static_cast<double>(p.bins);
  const double rate = points / cpu, peak_mb = peak_mib();
  const double index = static_cast<double>(p.index_bytes) / bins, records = static_cast<double>(p.record_bytes) / bins;
  const char* rule = o.params.representative == reduce::Representative::Centre ? "centre" : "surface";
  if (o.json) {
    std::printf(
        "{\"bench\": \"reduce\", \"representative\": \"%s\", \"threads\": %d, \"bin_mm\": %g, \"points\": %.0f, "
        "\"bins\": %.0f, \"kept\": %llu, \"cpu_s\": %.4f, \"wall_s\": %.4f, \"points_per_cpu_s\": %.0f, "
        "\"peak_mb\": %.1f, \"index_bytes_per_bin\": %.1f, \"record_bytes_per_bin\": %.1f}\n",
        rule, o.threads, o.bin_mm, points, bins, static_cast<unsigned long long>(p.kept), cpu, wall_s, rate, peak_mb,
        index, records);
    return;
  }
  std::printf("%s, %d threads, bins of %g mm: %.0f points, %.0f bins (%.1f to 1), %llu kept\n", rule, o.threads,
              o.bin_mm, points, bins, points / bins, static_cast<unsigned long long>(p.kept));
  std::printf("CPU %.3f s, wall %.3f s (medians of %d), %.1f M points per CPU second, peak %.0f MB\n", cpu, wall_s,
              o.repeat, rate * 1e-6, peak_mb);
  std::printf("bytes per bin: %.1f (index %.1f, records %.1f)\n", index + records, index, records);
}

Result<void> run(const Options& o) {
  Timing timing;
  reduce::Report report;
  for (int i = 0; i < o.repeat; ++i) {
    TRY_ASSIGN(const auto reduction, run_once(o, timing));
    TRY(check(reduction));
    report = reduction.report;
  }
  print(o, report, timing.cpu(), timing.wall());
  return run_rivals(o, timing.cpu());
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  return parse_options(argc, argv, options) ? exit_code("bench_reduce", run(options)) : usage();
}
