// SPDX-License-Identifier: Apache-2.0
#include "pipeline/bench_stages.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include "base/random.hpp"
#include "base/text.hpp"
#include "pipeline/bench_report.hpp"
#include "pipeline/cloud_measure.hpp"
#include "pipeline/judge_scan.hpp"
#include "pipeline/stopwatch.hpp"
#include "pipeline/tool_inputs.hpp"
#include "store/files.hpp"
#include "verify/quality.hpp"

namespace scanmill::pipeline {
namespace {

constexpr std::string_view kWords[] = {"reduce", "mesh", "optimise", "smooth", "feature", "quality", "verify"};
constexpr double kMadeBin = 1.0;  // about twenty points of the made cloud in each bin
constexpr std::uint64_t kLongestDocument = 16 << 20;

/// A sphere of 50 mm along a thousand scan lines of a thousand points, 25 um of noise, the same on every machine.
std::vector<Vec3> made_cloud() {
  constexpr int kLines = 1000;
  constexpr double kRadius = 50, kNoise = 0.025, kStep = 0.006283;  // a turn in a thousand steps
  Random random(20010401, 0, 0);
  std::vector<Vec3> points;
  points.reserve(kLines * kLines);
  for (int line = 0; line < kLines; ++line) {
    const double z = (line + 0.5) * 2 / kLines - 1, ring = std::sqrt(1 - z * z);
    Vec3 heading{1, 0, 0};
    for (int i = 0; i < kLines; ++i) {
      points.push_back(Vec3{ring * heading.x, ring * heading.y, z} * (kRadius + kNoise * random.gauss()));
      heading = unit(heading + Vec3{-heading.y, heading.x, 0} * kStep);
    }
  }
  return points;
}

/// Inputs and results of the stages so far.
struct Flow {
  const PointSource& points;
  const What& what;
  const Context& context;
  reduce::Reduction reduction;
  MeshedSurface surface;  // as meshed
  Mesh smoothed, finished;
};

/// One repeat: the timed call, its result kept in the flow. Returns the amount of work.
using StageCall = Result<std::uint64_t> (*)(Flow&, Stopwatch&);

Result<std::uint64_t> call_reduce(Flow& flow, Stopwatch& watch) {
  watch.start();
  auto reduced = reduce::reduce_cloud(flow.points, flow.what.lattice, flow.what.reduce, flow.context);
  watch.stop();
  TRY_ASSIGN(flow.reduction, std::move(reduced));
  return flow.reduction.report.points_read;
}

Result<std::uint64_t> call_mesh(Flow& flow, Stopwatch& watch) {
  NoProgress quiet;
  watch.start();
  auto meshed = mesh_surface(flow.reduction.cloud, flow.reduction.report.bounds, flow.what, flow.context, quiet);
  watch.stop();
  TRY_ASSIGN(flow.surface, std::move(meshed));
  return flow.reduction.report.kept;
}

Result<std::uint64_t> swap_edges(const Mesh& from, Mesh& to, const optimise::Params& passes, const Flow& flow,
                                 Stopwatch& watch) {
  const double range = flow.what.grow.range_bins * flow.reduction.report.bin_mm;
  const optimise::Limits limits{range, cos_of_degrees(flow.what.grow.min_angle_deg)};
  to = from;
  watch.start();
  const auto swapped = optimise::optimise(to, passes, limits, flow.context);
  watch.stop();
  if (!swapped.ok()) return swapped.error();
  return topology_of(to).edges;
}

Result<std::uint64_t> call_smooth(Flow& flow, Stopwatch& watch) {
  return swap_edges(flow.surface.mesh, flow.smoothed, {true, false}, flow, watch);
}

Result<std::uint64_t> call_feature(Flow& flow, Stopwatch& watch) {
  return swap_edges(flow.smoothed, flow.finished, {false, true}, flow, watch);
}

Result<std::uint64_t> call_quality(Flow& flow, Stopwatch& watch) {
  watch.start();
  const auto quality = verify::quality_of(flow.finished, flow.context);
  watch.stop();
  if (!quality.ok()) return quality.error();
  return static_cast<std::uint64_t>(flow.finished.triangles.size());
}

Result<std::uint64_t> call_verify(Flow& flow, Stopwatch& watch) {
  NoProgress quiet;
  std::swap(flow.surface.mesh, flow.finished);  // swaps keep the vertices, so their rows stay right
  watch.start();
  const auto fit = measure_fit(flow.surface, flow.reduction.cloud, flow.points, flow.what, flow.context, quiet);
  watch.stop();
  std::swap(flow.surface.mesh, flow.finished);
  if (!fit.ok()) return fit.error();
  return flow.reduction.report.points_read;
}

struct StageRow {
  const char *name, *group, *unit;
  StageCall call;
};
constexpr StageRow kStages[] = {
    {"reduce", "", "points", call_reduce},        {"mesh", "", "kept points", call_mesh},
    {"smooth", "optimise", "edges", call_smooth}, {"feature", "optimise", "edges", call_feature},
    {"quality", "", "triangles", call_quality},   {"verify", "", "points", call_verify},
};

Result<void> repeat(const StageRow& row, std::int64_t times, Flow& flow, Stopwatch& watch, BenchStage& stage,
                    Progress& progress) {
  for (std::int64_t k = 0; k < times; ++k) {
    if (flow.context.cancel.is_set()) return fail(Code::Cancelled, "stopped on request");
    progress.stage(row.name, static_cast<std::uint64_t>(k), static_cast<std::uint64_t>(times));
    TRY_ASSIGN(const std::uint64_t amount, row.call(flow, watch));
    if (stage.amount != 0 && stage.amount != amount)
      return fail(Code::Internal, std::string(row.name) + " worked on " + grouped(amount) + " " + row.unit + ", on " +
                                      grouped(stage.amount) + " the time before; please report this");
    stage.amount = amount;
  }
  progress.stage(row.name, static_cast<std::uint64_t>(times), static_cast<std::uint64_t>(times));
  stage.cpu_s = band_of(watch.cpu_seconds);
  stage.wall_s = band_of(watch.wall_seconds);
  stage.peak_bytes = watch.peak_bytes;
  return {};
}

/// Measures one stage; one that looks slower than `then` as often again, so that the band holds both rounds.
Result<BenchStage> measure(const StageRow& row, std::int64_t times, const BenchReport* then, Flow& flow,
                           Progress& progress) {
  BenchStage stage;
  stage.name = row.name;
  stage.unit = row.unit;
  Stopwatch watch;
  TRY(repeat(row, times, flow, watch, stage, progress));
  const BenchStage* earlier = then ? stage_named(*then, stage.name) : nullptr;
  if (earlier && is_slower(stage, *earlier)) TRY(repeat(row, times, flow, watch, stage, progress));
  return stage;
}

/// All stages that were asked for, in the order of the flow.
Result<void> measure_all(const BenchChoice& choice, const BenchReport* then, Flow& flow, BenchReport& report,
                         Progress& progress) {
  const auto wanted = [&](const StageRow& row) {
    return choice.stage.empty() || choice.stage == row.name || choice.stage == row.group;
  };
  const auto last = std::find_if(std::rbegin(kStages), std::rend(kStages), wanted).base();
  for (const StageRow* row = std::begin(kStages); row != last; ++row) {
    if (wanted(*row)) {
      TRY_ASSIGN(BenchStage stage, measure(*row, choice.repeats, then, flow, progress));
      report.stages.push_back(std::move(stage));
    } else {
      TRY(measure(*row, 1, nullptr, flow, progress));
    }
    if (row->call != call_reduce) continue;
    const reduce::Report& counts = flow.reduction.report;
    report.input.points = counts.points_read;
    report.input.bins = counts.bins;
    report.input.kept = counts.kept;
    report.input.bin_mm = counts.bin_mm;
    if (then) TRY(check_same_input(report.input, then->input, choice.against));
  }
  report.input.triangles = flow.surface.mesh.triangles.size();
  return {};
}

Result<void> check_choice(const BenchChoice& choice) {
  if (!choice.stage.empty() && std::find(std::begin(kWords), std::end(kWords), choice.stage) == std::end(kWords)) {
    std::string sentence = "found '" + choice.stage + "'; allowed " + document::joined(kWords);
    if (const std::string_view nearest = nearest_name(choice.stage, kWords); !nearest.empty())
      sentence += "; nearest " + std::string(nearest);
    return fail(Code::BadUsage, sentence, "command line: bench STAGE");
  }
  std::vector<std::string> inputs;
  for (const std::string& file : {choice.file, choice.against})
    if (!file.empty()) inputs.push_back(file);
  if (!choice.out.empty()) TRY(check_output(choice.out, {".json"}, inputs));
  return {};
}

Result<BenchReport> read_bench(const std::string& path) {
  TRY_ASSIGN(const auto source, store::open_file(path, path));
  TRY_ASSIGN(const std::string text, read_all(*source, kLongestDocument));
  TRY_ASSIGN(const document::Node root, document::parse_json(text, path));
  return bench_report_from(root, path);
}

/// The bin size of the job's words, else the file's suggestion, else that of the made cloud.
Result<What> with_bin(What what, const BenchChoice& choice, const PointSource& points, const Context& context,
                      Progress& progress) {
  if (what.lattice.bin_mm || what.lattice.target_points || what.lattice.target_bins) return what;
  what.lattice.bin_mm = kMadeBin;
  if (choice.file.empty()) return what;
  progress.stage("info", 0, 0);
  TRY_ASSIGN(const CloudMeasure seen, measure_cloud(points, context));
  if (!seen.suggested_bin_mm)
    return fail(Code::BadUsage, "too few points to choose a bin by; give --bin-mm", choice.file);
  what.lattice.bin_mm = seen.suggested_bin_mm;
  return what;
}

}  // namespace

std::span<const std::string_view> bench_stage_words() { return kWords; }

Result<ToolReport> bench_stages(const BenchChoice& choice, const What& given, const Context& context,
                                Progress& progress) {
  TRY(check_choice(choice));
  std::optional<BenchReport> then;
  if (!choice.against.empty()) {
    TRY_ASSIGN(then, read_bench(choice.against));
  }
  std::optional<OpenedInputs> opened;
  std::unique_ptr<PointSource> made;
  if (choice.file.empty()) {
    progress.stage("make", 0, 0);
    made = std::make_unique<MemoryPoints>(made_cloud());
  } else {
    TRY_ASSIGN(opened, open_inputs({choice.file}, given));
  }
  const PointSource& points = opened ? static_cast<const PointSource&>(*opened->points) : *made;
  TRY_ASSIGN(const What what, with_bin(given, choice, points, context, progress));

  BenchReport bench;
  bench.version = choice.version;
  bench.processor = choice.processor;
  bench.cores = choice.cores;
  bench.threads = context.loop.threads();
  bench.repeats = choice.repeats;
  bench.input.name = choice.file;
  bench.input.profile = profile_words()[static_cast<std::size_t>(what.profile)];
  Flow flow{points, what, context, {}, {}, {}, {}};
  auto measured = measure_all(choice, then ? &*then : nullptr, flow, bench, progress);
  if (!measured.ok()) {
    Error error = std::move(measured).error();
    return error.where.empty() && opened ? std::move(error).at(choice.file) : error;
  }
  if (opened) TRY(opened->points->verify_unchanged());

  ToolReport report;
  report.values = to_document(bench);
  if (!choice.out.empty()) TRY(store::write_text(choice.out, document::to_json(report.values, 2) + "\n"));
  report.text = bench_table(bench, then ? &*then : nullptr);
  if (then) {
    BenchComparison found = compare(bench, *then);
    report.values.set("against", choice.against);
    if (!found.notes.empty()) report.values.set("notes", texts(found.notes));
    for (const std::string& note : found.notes) report.text += "\n" + note;
    report.failed_gates = std::move(found.slowdowns);
  }
  return report;
}

}  // namespace scanmill::pipeline
