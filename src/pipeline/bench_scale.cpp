// SPDX-License-Identifier: Apache-2.0
#include "pipeline/bench_scale.hpp"

#include <stdlib.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string_view>
#include <tuple>

#include "base/digest.hpp"
#include "base/text.hpp"
#include "pipeline/bench_cloud.hpp"
#include "pipeline/scale_report.hpp"
#include "pipeline/stopwatch.hpp"
#include "pipeline/watched_child.hpp"
#include "render/png.hpp"
#include "store/files.hpp"

namespace scanmill::pipeline {

using document::Node;

namespace {

constexpr int kLookEveryMs = 20;
constexpr std::uint64_t kLongestRunFile = 64 << 20;
// A scan has a piece and a batch for each begun half gigabyte; smaller ones are asked for so many, or there would be
// next to nothing for processes to share.
constexpr std::uint64_t kBytesOfPart = 512ull << 20, kFewPieces = 4, kFewBatches = 8;
constexpr double kLeastPoints = 1e3, kMostScalePoints = 1e12;

Result<std::vector<std::uint64_t>> sizes_of(const ScaleChoice& choice) {
  std::vector<std::uint64_t> sizes;
  for (const std::string& word : choice.points) {
    const auto number = parse_number(word);
    if (!number || *number < kLeastPoints || *number > kMostScalePoints || *number != std::floor(*number))
      return fail(Code::BadUsage, "found '" + word + "'; allowed whole numbers from 1000 to 1e12 such as 1e6",
                  "command line: --points");
    sizes.push_back(static_cast<std::uint64_t>(*number));
  }
  if (choice.points.empty()) sizes = {100'000, 1'000'000, 10'000'000};
  std::sort(sizes.begin(), sizes.end());
  sizes.erase(std::unique(sizes.begin(), sizes.end()), sizes.end());
  return sizes;
}

/// The folder that clouds and output trees stand in; removed with what was not to be kept.
class Workshop {
 public:
  static Result<Workshop> open(const ScaleChoice& choice) {
    if (!choice.out.empty()) {
      TRY(store::make_folders(choice.out));
      return Workshop(std::filesystem::absolute(choice.out).string(), false);
    }
    std::error_code error;
    std::string path = (std::filesystem::temp_directory_path(error) / "scanmill-scale-XXXXXX").string();
    if (error || !mkdtemp(path.data()))
      return fail(Code::IoFailed, "takes no folder; set TMPDIR to one that does, or give --out",
                  error ? "TMPDIR" : path);
    return Workshop(path, true);
  }
  Workshop(Workshop&& other) noexcept : path_(std::move(other.path_)), passing_(other.passing_) {
    other.passing_ = false;
  }
  ~Workshop() {
    if (passing_) (void)store::remove_tree(path_);
  }
  const std::string& path() const { return path_; }

 private:
  Workshop(std::string path, bool passing) : path_(std::move(path)), passing_(passing) {}
  std::string path_;
  bool passing_;
};

std::string job_text(const ScaleChoice& choice, double bin_mm) {
  return "scanmill: 1\narchive: archive\nsettle_s: 0\nlattice: {bin_mm: " + number_text(bin_mm) + "}\n" +
         (choice.as_views ? "views:\n  - {name: cloud, files: 'cloud/view-*.ply'}\n" : "");
}

double number_in(const Node& map, const char* key) {
  const Node* value = map.find(key);
  return value && value->is_number() ? value->as_number() : 0;
}

/// What a stage works on: all points, the kept ones, or the triangles.
std::pair<const char*, std::uint64_t> work_of(const std::string& stage, const ScaleRun& run) {
  constexpr std::string_view kPoints[] = {"open", "clean", "reduce", "verify", "hash inputs"};
  constexpr std::string_view kTriangles[] = {"export", "record", "pictures", "report", "surfaces"};
  if (std::find(std::begin(kPoints), std::end(kPoints), stage) != std::end(kPoints)) return {"points", run.points};
  if (std::find(std::begin(kTriangles), std::end(kTriangles), stage) != std::end(kTriangles))
    return {"triangles", run.triangles};
  return {"kept points", run.kept};
}

/// Times are the run's own; memory is what was seen from outside, with the last stage ending when the run tells that
/// the scan is done.
void add_stages(const Node& seconds, const Node& cpu_seconds, const ChildRun& child, ScaleRun& run) {
  double total = 0;
  for (const Node::Entry& stage : seconds.entries()) total += number_in(seconds, stage.key.c_str());
  const std::size_t told = child.said.find("\"type\":\"scan\"");
  double end = child.wall_s;
  for (const TreeSample& sample : child.samples)
    if (told != std::string::npos && sample.said_bytes > child.said_from + told) {
      end = sample.wall_s;
      break;
    }
  double from = std::max(0.0, end - total);
  for (const Node::Entry& stage : seconds.entries()) {
    const double took = number_in(seconds, stage.key.c_str());
    BenchStage row;
    row.name = stage.key;
    std::tie(row.unit, row.amount) = work_of(stage.key, run);
    row.wall_s = timing::band_of({took});
    row.cpu_s = timing::band_of({number_in(cpu_seconds, stage.key.c_str())});
    for (const TreeSample& sample : child.samples)
      if (sample.wall_s >= from - 1e-3 * kLookEveryMs && sample.wall_s <= from + took + 1e-3 * kLookEveryMs)
        row.peak_bytes = std::max(row.peak_bytes, sample.held_bytes);
    run.stages.push_back(std::move(row));
    from += took;
  }
}

/// The words of `scanmill run` that cut the scan into bricks.
std::vector<std::string> cutting_words(std::int64_t bricks, std::uint64_t bytes) {
  if (bricks == 0) return {};
  std::vector<std::string> words{"--set", "brick.edge_bins=" + std::to_string(bricks)};
  const std::uint64_t by_bytes = bytes / kBytesOfPart + 1;
  if (by_bytes < kFewPieces) words.insert(words.end(), {"--set", "brick.pieces=" + std::to_string(kFewPieces)});
  if (by_bytes < kFewBatches) words.insert(words.end(), {"--set", "brick.batches=" + std::to_string(kFewBatches)});
  return words;
}

Result<std::string> mesh_digest(const std::string& out) {
  const std::string path = out + "/scans/cloud/mesh.stl";
  TRY_ASSIGN(const auto source, store::open_file(path, path));
  return sha256_of(*source);
}

/// `run` has points, bricks and threads; the rest is filled in.
Result<ScaleRun> run_once(const ScaleChoice& choice, const std::string& folder, std::uint64_t bytes, ScaleRun run,
                          const Context& context) {
  const std::string out =
      folder + "/out-" + std::to_string(run.threads) + (run.bricks == 0 ? "" : "-bricks-" + std::to_string(run.bricks));
  TRY(store::remove_tree(out));
  std::vector<std::string> words{choice.executable, "run",       folder + "/job.yaml",       "--out", out,
                                 "--json",          "--threads", std::to_string(run.threads)};
  const std::vector<std::string> cutting = cutting_words(run.bricks, bytes);
  words.insert(words.end(), cutting.begin(), cutting.end());
  if (!choice.memory.empty()) words.insert(words.end(), {"--memory", choice.memory});
  TRY_ASSIGN(const ChildRun child, run_watched(words, kLookEveryMs, context));
  if (child.exit_code != 0) {
    const std::string why = failure_in(child.said);
    return fail(Code::BadInput,
                "scanmill run over " + name_of(run) + " ends with exit code " + std::to_string(child.exit_code) +
                    (why.empty() ? " and says nothing" : ": " + why),
                folder);
  }
  TRY_ASSIGN(const auto source, store::open_file(out + "/run.json", out + "/run.json"));
  TRY_ASSIGN(const std::string text, read_all(*source, kLongestRunFile));
  TRY_ASSIGN(const Node document, document::parse_json(text, out + "/run.json"));
  const Node* scans = document.find("scans");
  const Node* counts =
      scans && scans->is_sequence() && scans->items().size() == 1 ? scans->items()[0].find("counts") : nullptr;
  if (!counts || static_cast<std::uint64_t>(number_in(*counts, "points_read")) != run.points)
    return fail(Code::Internal, "found no scan of " + counted(run.points, "point") + "; please report this",
                out + "/run.json");
  run.bins = static_cast<std::uint64_t>(number_in(*counts, "bins"));
  run.kept = static_cast<std::uint64_t>(number_in(*counts, "kept"));
  run.triangles = static_cast<std::uint64_t>(number_in(*counts, "triangles"));
  run.cpu_s = child.cpu_s;
  run.wall_s = child.wall_s;
  run.peak_bytes = child.peak_held;
  run.peak_resident = child.peak_resident;
  TRY_ASSIGN(run.stl_sha256, mesh_digest(out));
  const Node *wall = scans->items()[0].find("stage_seconds"), *cpu = scans->items()[0].find("stage_cpu_seconds");
  // Of a scan in bricks these are the times of its last task alone.
  if (run.bricks == 0 && wall && wall->is_map() && cpu && cpu->is_map()) add_stages(*wall, *cpu, child, run);
  if (!choice.keep) TRY(store::remove_tree(out));
  return run;
}

/// One size: its cloud, its job, its runs.
Result<void> measure_size(const ScaleChoice& choice, const Workshop& shop, std::uint64_t points, ScaleReport& report,
                          const Context& context, Progress& progress) {
  const std::string folder = shop.path() + "/points-" + std::to_string(points);
  const simulate::BumpyBall ball(points, choice.seed);
  const double bin_mm = scale_bin_mm(choice.per_bin);
  Stopwatch watch;
  watch.start();
  TRY_ASSIGN(
      const std::uint64_t bytes,
      write_bench_cloud(ball, folder + (choice.as_views ? "/archive/cloud" : "/archive/cloud.ply"), context, progress));
  watch.stop();
  report.made.push_back({points, bytes, watch.cpu_seconds[0], watch.wall_seconds[0]});
  TRY(store::write_text(folder + "/job.yaml", job_text(choice, bin_mm)));
  std::uint64_t done = 0;
  for (const std::int64_t bricks : choice.bricks)
    for (const std::int64_t threads : choice.threads) {
      progress.stage("run " + grouped(points), done++, choice.bricks.size() * choice.threads.size());
      ScaleRun asked;
      asked.points = points;
      asked.bricks = bricks;
      asked.threads = threads;
      asked.bin_mm = bin_mm;
      TRY_ASSIGN(ScaleRun run, run_once(choice, folder, bytes, std::move(asked), context));
      TRY(check_same_mesh(report, run));
      report.runs.push_back(std::move(run));
    }
  if (!choice.keep) TRY(store::remove_tree(folder));
  return {};
}

Result<ToolReport> generate(const ScaleChoice& choice, const std::vector<std::uint64_t>& sizes, const Context& context,
                            Progress& progress) {
  if (choice.points.size() != 1)
    return fail(Code::BadUsage,
                "found " + counted(choice.points.size(), "number") + "; --generate makes one cloud: give one",
                "command line: --points");
  const simulate::BumpyBall ball(sizes[0], choice.seed);
  Stopwatch watch;
  watch.start();
  TRY_ASSIGN(const std::uint64_t bytes, write_bench_cloud(ball, choice.generate, context, progress));
  watch.stop();
  ToolReport report;
  report.values.set("path", choice.generate);
  report.values.set("points", ball.points());
  report.values.set("bytes", bytes);
  report.values.set("views", static_cast<std::uint64_t>(ball.views()));
  report.values.set("seed", choice.seed);
  report.values.set("radius_mm", ball.radius_mm());
  report.values.set("noise_mm", ball.kNoiseMm);
  report.values.set("bin_mm", scale_bin_mm(choice.per_bin));
  report.values.set("points_per_cpu_s", static_cast<double>(ball.points()) / std::max(watch.cpu_seconds[0], 1e-6));
  return report;
}

}  // namespace

double scale_bin_mm(double per_bin) {
  // To a thousandth of a millimetre, so that the job reads well.
  return std::max(1.0, std::floor(1e3 * std::sqrt(1.5 * per_bin / simulate::BumpyBall::kPointsPerMm2) + 0.5)) / 1e3;
}

Result<ToolReport> bench_scale(const ScaleChoice& given, const Context& context, Progress& progress) {
  ScaleChoice choice = given;
  TRY_ASSIGN(const std::vector<std::uint64_t> sizes, sizes_of(choice));
  if (!choice.generate.empty()) return generate(choice, sizes, context, progress);
  if (choice.threads.empty()) choice.threads = {choice.cores};
  if (choice.bricks.empty()) choice.bricks = {0};
  std::sort(choice.bricks.begin(), choice.bricks.end());
  choice.bricks.erase(std::unique(choice.bricks.begin(), choice.bricks.end()), choice.bricks.end());
  if (choice.keep && choice.out.empty())
    return fail(Code::BadUsage, "keeps clouds and output trees in the folder of --out; give one",
                "command line: --keep");
  TRY_ASSIGN(const Workshop shop, Workshop::open(choice));
  unsetenv("GITHUB_STEP_SUMMARY");  // the runs below are none of the build's steps

  ScaleReport found;
  found.version = choice.version;
  found.processor = choice.processor;
  found.cores = choice.cores;
  found.memory = choice.memory;
  found.seed = choice.seed;
  found.per_bin = choice.per_bin;
  found.as_views = choice.as_views;
  for (const std::uint64_t points : sizes) TRY(measure_size(choice, shop, points, found, context, progress));

  ToolReport report;
  report.values = to_document(found);
  report.text = scale_table(found);
  if (!choice.out.empty()) {
    TRY(store::write_text(shop.path() + "/scale.json", document::to_json(report.values, 2) + "\n"));
    TRY_ASSIGN(const auto sink, store::create_file(shop.path() + "/scale.png"));
    TRY(render::write_png(scale_picture(found), *sink));
    TRY(sink->commit());
  }
  return report;
}

}  // namespace scanmill::pipeline
