// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <filesystem>
#include <map>

#include "base/digest.hpp"
#include "base/text.hpp"
#include "cloud/over_blocks.hpp"
#include "pipeline/plan_files.hpp"
#include "pipeline/plan_scan.hpp"
#include "pipeline/replay_plan.hpp"
#include "pipeline/views.hpp"
#include "pipeline/watched_points.hpp"
#include "store/files.hpp"

namespace scanmill::pipeline {
namespace {

constexpr double kBinsWithoutSensor = 20000;

Result<plan::ScanPlan> read_plan(const std::string& path) {
  TRY_ASSIGN(const auto source, store::open_file(path, path));
  TRY_ASSIGN(const std::string text, read_all(*source, kLongestPlan));
  TRY_ASSIGN(const document::Node root, document::parse_yaml(text, path));
  return plan::plan_from(root, path);
}

/// A plan that is not there or cannot be read is the command line's or the plan's fault.
Error as_plan_error(Error error) {
  if (error.code == Code::BadInput) error.code = Code::BadParameter;
  return error;
}

class Rehearsing {
 public:
  Rehearsing(Rehearsal& out, const ReplayChoice& choice, const Context& context, Progress& progress)
      : out_(out), choice_(choice), context_(context), progress_(progress) {
    folder_ = std::filesystem::path(out.path).parent_path().string();
    if (folder_.empty()) folder_ = ".";
  }

  Result<void> look_at_files() {
    const auto& stations = out_.plan.stations;
    std::vector<std::size_t> missing;
    for (std::size_t s = 0; s < stations.size(); ++s) {
      if (stations[s].data.empty()) continue;
      ++out_.files_named;
      if (store::stamp_of(file_of(s)).ok()) {
        ++out_.files_there;
        there_.push_back(s);
      } else {
        missing.push_back(s);
      }
    }
    if (out_.files_there == 0) return {};  // not scanned yet
    for (const std::size_t s : missing)
      note(s, "missing",
           "the file " + stations[s].data + " is not there; copy it, or take the station out of the plan");
    return compare_hashes();
  }

  Result<void> open_views() {
    if (there_.empty()) return {};
    auto points = open(there_);
    if (!points.ok()) {
      // One by one, so that each view that cannot be read is named.
      std::vector<std::size_t> sound;
      for (const std::size_t s : there_) {
        const auto alone = open({s});
        if (alone.ok())
          sound.push_back(s);
        else
          note(s, "unreadable", alone.error().text());
      }
      if (sound.empty()) return {};
      points = open(sound);
      if (!points.ok()) return std::move(points).error();
    }
    out_.points = std::move(points).value();
    std::map<std::string, std::size_t> by_name;
    for (std::size_t s = 0; s < out_.plan.stations.size(); ++s) by_name[out_.plan.stations[s].name] = s;
    for (const OpenView& view : out_.points->views())
      out_.station_of.push_back(by_name[out_.points->specs()[index_of(view.id)].station]);
    return {};
  }

  /// Reads everything once; more often for the coverage.
  Result<void> look_at_points(bool with_coverage) {
    if (!out_.points) return {};
    if (with_coverage) {
      TRY(bin_points());
    } else if (out_.plan.has_sensor) {
      const WatchedPoints watched(*out_.points, "read", progress_);
      if (auto read = over_blocks(watched, context_, [](int, PointBlock&) -> Result<void> { return {}; }); !read.ok())
        TRY(keep(std::move(read).error(), "unreadable"));
    }
    for (plan::Finding& finding : out_.points->band_findings()) {
      const auto at = std::find_if(out_.plan.stations.begin(), out_.plan.stations.end(),
                                   [&](const plan::Station& station) { return station.name == finding.station; });
      out_.replay.steps[static_cast<std::size_t>(at - out_.plan.stations.begin())].state.findings.push_back(
          std::move(finding));
    }
    return {};
  }

 private:
  std::string file_of(std::size_t s) const { return folder_ + "/" + out_.plan.stations[s].data; }

  void note(std::size_t s, const char* kind, const std::string& sentence) {
    const std::string& name = out_.plan.stations[s].name;
    out_.replay.steps[s].state.findings.push_back(
        {plan::Severity::Error, kind, name, "", 0, 0, "station " + name + ": " + sentence});
  }

  /// An error that belongs to the scan's input becomes a finding; others stop the replay.
  Result<void> keep(Error error, const char* kind) {
    if (error.code != Code::BadInput && error.code != Code::Unsupported) return error;
    const std::string text = error.text();
    for (std::size_t s = 0; s < out_.plan.stations.size(); ++s)
      if (!out_.plan.stations[s].data.empty() && text.starts_with(plain_path(out_.plan.stations[s].data))) {
        note(s, kind, text);
        return {};
      }
    out_.elsewhere.push_back({plan::Severity::Error, kind, "", "", 0, 0, text});
    return {};
  }

  Result<void> compare_hashes() {
    std::vector<Result<std::string>> digests(there_.size(), Result<std::string>(std::string()));
    context_.loop.run(there_.size(), [&](std::size_t k, int) {
      if (!out_.plan.stations[there_[k]].sha256 || context_.cancel.is_set()) return;
      const auto file = store::open_file(file_of(there_[k]), out_.plan.stations[there_[k]].data);
      digests[k] = file.ok() ? sha256_of(**file) : Result<std::string>(file.error());
    });
    if (context_.cancel.is_set()) return fail(Code::Cancelled, "stopped while view files were hashed");
    for (std::size_t k = 0; k < there_.size(); ++k) {
      const plan::Station& station = out_.plan.stations[there_[k]];
      if (!station.sha256) continue;
      if (!digests[k].ok())
        note(there_[k], "unreadable", digests[k].error().text());
      else if (*digests[k] != *station.sha256)
        note(there_[k], "changed",
             "the file " + station.data + " has SHA-256 " + *digests[k] + ", the plan names " + *station.sha256 +
                 "; it was changed or exchanged");
    }
    return {};
  }

  Result<std::unique_ptr<ScanPoints>> open(const std::vector<std::size_t>& stations) const {
    plan::ScanPlan some = out_.plan;
    some.stations.clear();
    for (const std::size_t s : stations) some.stations.push_back(out_.plan.stations[s]);
    ScanSpec scan;
    scan.kind = ScanKind::Plan;
    scan.name = scan.description = std::filesystem::path(out_.path).filename().string();
    views_of_plan(some, scan);
    return ScanPoints::open(folder_, scan, 1);
  }

  Result<void> bin_points() {
    reduce::LatticeParams lattice;
    const scanmill::Sensor& sensor = out_.plan.sensor;
    if (choice_.bin_mm)
      lattice.bin_mm = choice_.bin_mm;
    else if (out_.plan.has_sensor)
      lattice.bin_mm = 10 * std::max(sensor.field_x_mm / static_cast<double>(sensor.pixels_x),
                                     sensor.field_y_mm / static_cast<double>(sensor.pixels_y));
    else
      lattice.target_bins = kBinsWithoutSensor;
    reduce::Params params;
    params.representative = reduce::Representative::Centre;
    params.min_neighbour_distance.reset();
    const WatchedPoints watched(*out_.points, "bins", progress_);
    auto reduced = reduce::reduce_cloud(watched, lattice, params, context_);
    if (!reduced.ok()) return keep(std::move(reduced).error(), "unreadable");
    out_.bins = std::move(reduced).value();
    const reduce::Report& report = out_.bins->report;
    if (const std::string problem = implausible_size(report.bounds, out_.plan.units_mm, 0); !problem.empty())
      out_.elsewhere.push_back({plan::Severity::Error, "units", "", "", 0, 0, problem});
    TRY_ASSIGN(out_.coverage, coverage_of(*out_.points, out_.bins->cloud, context_, progress_));
    return {};
  }

  Rehearsal& out_;
  const ReplayChoice& choice_;
  const Context& context_;
  Progress& progress_;
  std::string folder_;
  std::vector<std::size_t> there_;
};

}  // namespace

std::vector<std::string> Rehearsal::texts(plan::Severity severity) const {
  std::vector<std::string> lines;
  for (const plan::Step& step : replay.steps)
    for (const plan::Finding& finding : step.state.findings)
      if (finding.severity == severity) lines.push_back(finding.text);
  for (const plan::Finding& finding : elsewhere)
    if (finding.severity == severity) lines.push_back(finding.text);
  return lines;
}

Result<Rehearsal> rehearse(const std::string& path, const ReplayChoice& choice, bool look, const Context& context,
                           Progress& progress) {
  Rehearsal out;
  out.path = path;
  auto plan = read_plan(path);
  if (!plan.ok()) return as_plan_error(std::move(plan).error());
  out.plan = std::move(plan).value();
  out.replay = plan::replay(out.plan);
  Rehearsing rehearsing(out, choice, context, progress);
  TRY(rehearsing.look_at_files());
  TRY(rehearsing.open_views());
  TRY(rehearsing.look_at_points(look));
  plan::count_findings(out.replay);
  for (const plan::Finding& finding : out.elsewhere)
    ++(finding.severity == plan::Severity::Error ? out.replay.totals.errors : out.replay.totals.warnings);
  return out;
}

}  // namespace scanmill::pipeline
