// SPDX-License-Identifier: Apache-2.0
#include "pipeline/replay_plan.hpp"

#include <unistd.h>

#include <cmath>
#include <filesystem>

#include "base/text.hpp"
#include "cloud/over_blocks.hpp"
#include "export/writers.hpp"
#include "pipeline/replay_pictures.hpp"
#include "pipeline/tool_inputs.hpp"
#include "store/files.hpp"

namespace scanmill::pipeline {
namespace {

using document::Node;

Node number_or_null(const std::optional<double>& value) { return value ? Node(*value) : Node(); }

Node finding_node(const plan::Finding& finding) {
  Node node = Node::map();
  node.set("severity", finding.severity == plan::Severity::Error ? "error" : "warning");
  node.set("kind", finding.kind);
  if (!finding.station.empty()) node.set("station", finding.station);
  if (!finding.joint.empty()) node.set("joint", finding.joint);
  node.set("value", finding.value);
  node.set("limit", finding.limit);
  node.set("text", finding.text);
  return node;
}

/// Joint name -> value, or null when no joints are known.
template <class T>
Node by_joint(const plan::Machine& machine, const std::vector<T>& values, bool counted_only) {
  Node node = Node::map();
  for (std::size_t i = 0; i < values.size(); ++i)
    if (!counted_only || plan::counts_per_turn(machine.joints[i]) > 0) node.set(machine.joints[i].name, values[i]);
  return node;
}

void add_machine_state(const Rehearsal& r, const plan::Step& step, Node& node) {
  if (!r.plan.machine || !step.state.known) {
    for (const char* key : {"joints", "turns", "counts"}) node.set(key, Node());
    return;
  }
  const plan::Machine& machine = *r.plan.machine;
  node.set("joints", by_joint(machine, step.state.joints, false));
  node.set("turns", by_joint(machine, step.state.turns, false));
  node.set("counts", by_joint(machine, step.state.counts, true));
  if (step.state.commanded.empty()) return;
  node.set("commanded", by_joint(machine, step.state.commanded, false));
  std::vector<double> off;
  for (std::size_t i = 0; i < step.state.joints.size(); ++i)
    off.push_back(step.state.joints[i] - step.state.commanded[i]);
  node.set("off_command", by_joint(machine, off, false));
}

Node station_node(const Rehearsal& r, std::size_t s) {
  const plan::Step& step = r.replay.steps[s];
  const plan::Station& station = r.plan.stations[s];
  Node node = Node::map();
  node.set("name", station.name);
  add_machine_state(r, step, node);
  Node pose = Node::sequence();
  for (const double value : station.pose.matrix()) pose.push(value);
  node.set("pose", std::move(pose));
  node.set("begin_s", number_or_null(step.begin_s));
  node.set("time_s", number_or_null(step.time_s));
  node.set("path_mm", step.path_mm);
  if (!station.data.empty()) node.set("data", station.data);
  for (std::size_t v = 0; r.points && r.bins && v < r.station_of.size(); ++v) {
    if (r.station_of[v] != s) continue;
    const ViewCounts counts = r.points->counts()[v];
    node.set("points", counts.kept());
    if (counts.band.points > 0) {
      Node depth = Node::sequence();
      depth.push(counts.band.nearest_mm);
      depth.push(counts.band.farthest_mm);
      node.set("depth_mm", std::move(depth));
      node.set("outside_band", counts.band.too_near + counts.band.too_far);
      node.set("beside_field", counts.band.beside);
    }
    if (!r.coverage) continue;
    const ViewCoverage& seen = r.coverage->views[v];
    Node& coverage = node.set("coverage", Node::map());
    coverage.set("bins", seen.bins);
    coverage.set("only_here", seen.only_here);
    coverage.set("median_angle_deg", seen.median_angle_deg);
    if (seen.best_overlap > 0) {
      coverage.set("best_overlap", seen.best_overlap);
      coverage.set("with", r.plan.stations[r.station_of[seen.best_neighbour]].name);
    }
  }
  Node& findings = node.set("findings", Node::sequence());
  for (const plan::Finding& finding : step.state.findings) findings.push(finding_node(finding));
  return node;
}

Node coverage_node(const Coverage& coverage) {
  Node node = Node::map();
  node.set("bin_mm", coverage.bin_mm);
  node.set("bins", coverage.bins);
  Node seen = Node::sequence();
  for (const std::uint64_t count : coverage.seen_by) seen.push(count);
  node.set("seen_by", std::move(seen));
  node.set("median_best_angle_deg", coverage.bins_with_angle > 0 ? Node(coverage.median_best_angle_deg) : Node());
  node.set("bins_within_60_deg", coverage.bins_within_60_deg);
  node.set("bins_with_angle", coverage.bins_with_angle);
  return node;
}

std::string timeline_text(const Rehearsal& r) {
  std::string text = "station\tbegin_s\tarrive_s\tleave_s\tmove_s\tpath_mm";
  const std::size_t joints = r.plan.machine ? r.plan.machine->joints.size() : 0;
  for (std::size_t i = 0; i < joints; ++i)
    text += "\t" + r.plan.machine->joints[i].name + "_" + plan::unit_of(r.plan.machine->joints[i]);
  text += "\n";
  const auto cell = [](const std::optional<double>& value) { return "\t" + (value ? number_text(*value) : "-"); };
  for (std::size_t s = 0; s < r.replay.steps.size(); ++s) {
    const plan::Step& step = r.replay.steps[s];
    std::optional<double> move, arrive, leave;
    if (step.move) move = step.move->time_s;
    if (step.begin_s && move) arrive = *step.begin_s + *move;
    if (step.begin_s && step.time_s) leave = *step.begin_s + *step.time_s;
    text += r.plan.stations[s].name + cell(step.begin_s) + cell(arrive) + cell(leave) + cell(move) + "\t" +
            number_text(step.path_mm);
    for (std::size_t i = 0; i < joints; ++i)
      text += step.state.known ? "\t" + number_text(step.state.joints[i]) : "\t-";
    text += "\n";
  }
  return text;
}

/// All points in the global frame; blocks are read on all threads and written in order.
Result<void> write_cloud(const Rehearsal& r, const std::string& path, const Context& context, Progress& progress) {
  const ScanPoints& points = *r.points;
  std::uint64_t count = 0, done = 0;
  for (const ViewCounts& counts : points.counts()) count += counts.kept();
  TRY_ASSIGN(auto sink, store::create_file(path));
  std::vector<std::string> comments{"scanmill replay: global frame, mm"};
  for (std::size_t v = 0; v < points.views().size(); ++v)
    comments.push_back("view " + std::to_string(index_of(points.views()[v].id)) + " " + points.views()[v].path);
  TRY_ASSIGN(exporting::PlyPointWriter writer, exporting::PlyPointWriter::begin(*sink, count, comments));
  const std::size_t group = 2 * static_cast<std::size_t>(context.loop.threads());
  std::vector<PointBlock> blocks(group);
  for (std::size_t first = 0; first < points.block_count(); first += group) {
    const std::size_t some = std::min(group, points.block_count() - first);
    FirstBlockError error;
    context.loop.run(some, [&](std::size_t k, int) {
      if (auto read = points.read_block(first + k, blocks[k]); !read.ok()) error.report(k, std::move(read).error());
    });
    TRY(error.take(context));
    for (std::size_t k = 0; k < some; ++k) {
      TRY(writer.add(blocks[k]));
      progress.stage("cloud", done += blocks[k].positions.size(), count);
    }
  }
  TRY(writer.finish());
  TRY(points.verify_unchanged());
  return sink->commit();
}

/// What people see: the values of both commands.
Node summary(const Rehearsal& r) {
  Node node = Node::map();
  node.set("plan", r.path);
  node.set("stations", static_cast<std::uint64_t>(r.plan.stations.size()));
  if (r.plan.machine) {
    node.set("machine", r.plan.machine->name);
    std::string chain;
    for (const plan::Joint& joint : r.plan.machine->joints) chain += (chain.empty() ? "" : " ") + joint.name;
    if (!chain.empty()) node.set("joints", chain);
  }
  const plan::Totals& totals = r.replay.totals;
  if (totals.time_s) node.set("time_s", std::floor(*totals.time_s * 100 + 0.5) / 100);
  node.set("path_mm", std::floor(totals.path_mm * 100 + 0.5) / 100);
  node.set("files", r.files_there == r.files_named
                        ? std::to_string(r.files_there) + " of " + std::to_string(r.files_named) + " there"
                    : r.files_there == 0
                        ? std::string("none of " + std::to_string(r.files_named) + " is there yet")
                        : std::to_string(r.files_there) + " of " + std::to_string(r.files_named) + " there");
  if (const auto warnings = r.texts(plan::Severity::Warning); !warnings.empty()) node.set("warnings", texts(warnings));
  return node;
}

/// A hidden folder in the one to be written: files get their places when all of them are whole.
class Staging {
 public:
  explicit Staging(const std::string& folder)
      : folder_(folder), path_(folder + "/.replay-" + std::to_string(::getpid())) {}
  ~Staging() { (void)store::remove_tree(path_); }
  Staging(const Staging&) = delete;
  Staging& operator=(const Staging&) = delete;
  const std::string& path() const { return path_; }

  Result<void> make() const {
    TRY(store::remove_tree(path_));
    return store::make_folders(path_);
  }
  /// The first of the files last: who finds it finds the others of the same replay.
  Result<void> put_in_place(const std::vector<std::string>& files) const {
    for (std::size_t n = files.size(); n-- > 0;) {
      std::error_code error;
      std::filesystem::rename(path_ + "/" + files[n], folder_ + "/" + files[n], error);
      if (error)
        return fail(Code::IoFailed, "cannot put the finished file in place: " + error.message(),
                    folder_ + "/" + files[n]);
    }
    return store::sync_folder(folder_);
  }

 private:
  std::string folder_, path_;
};

std::string error_lines(const Rehearsal& r) {
  std::string lines;
  for (const std::string& line : r.texts(plan::Severity::Error))
    lines += (lines.empty() ? "" : "\n") + r.path + ": " + line;
  return lines;
}

}  // namespace

Node replay_document(const Rehearsal& r) {
  Node root = Node::map();
  root.set("scanmill_replay", 1);
  root.set("plan", r.plan.name);
  if (r.plan.machine) root.set("machine", r.plan.machine->name);
  Node& stations = root.set("stations", Node::sequence());
  for (std::size_t s = 0; s < r.plan.stations.size(); ++s) stations.push(station_node(r, s));
  const plan::Totals& totals = r.replay.totals;
  Node& sums = root.set("totals", Node::map());
  sums.set("time_s", number_or_null(totals.time_s));
  sums.set("moving_s", number_or_null(totals.moving_s));
  sums.set("path_mm", totals.path_mm);
  if (r.plan.machine) sums.set("travel", by_joint(*r.plan.machine, totals.travel, false));
  if (r.bins) {
    sums.set("points", r.bins->report.points_used);
    sums.set("low_mm", triple(r.bins->report.bounds.low));
    sums.set("high_mm", triple(r.bins->report.bounds.high));
  }
  if (r.coverage) sums.set("coverage", coverage_node(*r.coverage));
  sums.set("errors", totals.errors);
  sums.set("warnings", totals.warnings);
  Node& findings = sums.set("findings", Node::sequence());  // of no single station
  for (const plan::Finding& finding : r.elsewhere) findings.push(finding_node(finding));
  return root;
}

Result<ToolReport> replay_plan(const std::string& path, const std::string& wanted_folder, const ReplayChoice& choice,
                               const Context& context, Progress& progress) {
  const std::string folder =
      wanted_folder.empty() ? std::filesystem::path(path).stem().string() + ".replay" : wanted_folder;
  TRY_ASSIGN(const Rehearsal r, rehearse(path, choice, true, context, progress));
  TRY(store::make_folders(folder));
  Staging staging(folder);
  TRY(staging.make());
  ToolReport report;
  report.values = summary(r);
  Node& out = report.values;
  std::vector<std::string> written{"replay.json", "timeline.tsv"};
  TRY(store::write_text(staging.path() + "/replay.json", document::to_json(replay_document(r), 1) + "\n"));
  TRY(store::write_text(staging.path() + "/timeline.tsv", timeline_text(r)));
  if (r.bins) {
    out.set("points", r.bins->report.points_used);
    out.set("low_mm", triple(r.bins->report.bounds.low));
    out.set("high_mm", triple(r.bins->report.bounds.high));
    if (!choice.no_cloud) {
      TRY(write_cloud(r, staging.path() + "/cloud.ply", context, progress));
      written.push_back("cloud.ply");
    }
  }
  if (r.coverage) {
    const Coverage& seen = *r.coverage;
    out.set("bin_mm", seen.bin_mm);
    out.set("bins", seen.bins);
    std::uint64_t twice = 0;
    for (std::size_t n = 1; n < seen.seen_by.size(); ++n) twice += seen.seen_by[n];
    out.set("bins_seen_twice_or_more", twice);
    if (seen.bins_with_angle > 0) {  // without a sensor nobody says where the views were looked at from
      out.set("bins_within_60_deg", seen.bins_within_60_deg);
      out.set("median_best_angle_deg", std::floor(seen.median_best_angle_deg * 10 + 0.5) / 10);
    }
  }
  if (!choice.no_pictures) {
    TRY_ASSIGN(const std::vector<std::string> names, write_replay_pictures(r, staging.path(), context, progress));
    written.insert(written.end(), names.begin(), names.end());
  }
  TRY(staging.put_in_place(written));
  out.set("folder", folder);
  std::string all;
  for (const std::string& name : written) all += (all.empty() ? "" : " ") + name;
  out.set("written", all);
  if (r.has_errors())
    return fail(Code::BadParameter, error_lines(r) + "\nall findings are in " + folder + "/replay.json");
  return report;
}

Result<ToolReport> check_plan(const std::string& path, const Context& context, Progress& progress) {
  TRY_ASSIGN(const Rehearsal r, rehearse(path, {}, false, context, progress));
  if (r.has_errors()) return fail(Code::BadParameter, error_lines(r));
  ToolReport report;
  report.values = summary(r);
  return report;
}

}  // namespace scanmill::pipeline
