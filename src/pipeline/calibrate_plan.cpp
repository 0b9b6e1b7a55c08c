// SPDX-License-Identifier: Apache-2.0
#include "pipeline/calibrate_plan.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "base/text.hpp"
#include "pipeline/plan_files.hpp"
#include "pipeline/plan_scan.hpp"
#include "pipeline/scan_points.hpp"
#include "pipeline/tool_inputs.hpp"
#include "plan/calibrate.hpp"
#include "plan/stations.hpp"

namespace scanmill::pipeline {
namespace {

using document::Node;

constexpr std::size_t kMostPoints = 20000;  // of a view, evenly out of all

double to_micrometre(double value) { return std::floor(value * 1e5 + 0.5) / 1e5; }

/// Every so many points, so that about kMostPoints stay.
void thin(std::vector<Vec3>& points) {
  const std::size_t stride = points.size() / kMostPoints + 1;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < points.size(); i += stride) points[kept++] = points[i];
  points.resize(kept);
}

/// The points of every view in the sensor's frame, thinned; in the order of the stations.
Result<std::vector<plan::TargetView>> views_of(const plan::ScanPlan& plan, const std::vector<plan::State>& states,
                                               const std::string& path, const Context& context, Progress& progress) {
  std::string folder = std::filesystem::path(path).parent_path().string();
  if (folder.empty()) folder = ".";
  plan::ScanPlan known = plan;
  known.stations.clear();
  std::vector<plan::TargetView> views;
  for (std::size_t s = 0; s < plan.stations.size(); ++s) {
    if (plan.stations[s].via || plan.stations[s].data.empty() || !states[s].known) continue;
    known.stations.push_back(plan.stations[s]);
    views.push_back({plan.stations[s].name, states[s].joints, {}});
  }
  ScanSpec scan;
  scan.name = scan.description = std::filesystem::path(path).filename().string();
  views_of_plan(known, scan);
  for (ViewSpec& view : scan.views) view.pose = Pose{};
  TRY_ASSIGN(const auto points, ScanPoints::open(folder, scan, 1));
  PointBlock block;
  std::size_t view = 0;
  for (std::size_t b = 0; b < points->block_count(); ++b) {
    if (context.cancel.is_set()) return fail(Code::Cancelled, "stopped on request", path);
    progress.stage("calibrate", b, points->block_count());
    block.clear();
    TRY(points->read_block(b, block));
    const std::string& station = points->specs()[index_of(block.view)].station;
    if (views[view].station != station) {
      thin(views[view].points);
      while (views[view].station != station) ++view;
    }
    views[view].points.insert(views[view].points.end(), block.positions.begin(), block.positions.end());
  }
  if (!views.empty()) thin(views[view].points);
  return views;
}

Result<plan::CalibrateParams> params_of(const CalibrateChoice& choice, const plan::ScanPlan& plan,
                                        const std::string& path) {
  plan::CalibrateParams params;
  if (choice.target == "plane")
    params.kind = plan::TargetKind::Plane;
  else if (choice.target != "sphere")
    return fail(Code::BadUsage, "found '" + choice.target + "'; allowed sphere, plane", "--target");
  params.radius_mm = choice.radius_mm;
  params.noise_mm = plan.sensor.noise_mm;
  if (!plan.machine || plan.machine->joints.empty())
    return fail(Code::BadParameter, "the plan has no machine with joints; its poses do not depend on the mount", path);
  for (const std::string& name : choice.axes) {
    const auto axis = plan.machine->find(name);
    if (!axis) return fail(Code::BadUsage, "the machine of " + path + " has no joint '" + name + "'", "--axes");
    params.axes.push_back(*axis);
  }
  return params;
}

Node node_of(const plan::Calibration& found) {
  Node out = Node::map();
  out.set("rms_before_mm", to_micrometre(found.before_mm));
  out.set("rms_after_mm", to_micrometre(found.after_mm));
  if (found.radius_mm > 0) out.set("radius_mm", to_micrometre(found.radius_mm));
  for (const plan::Unknown& unknown : found.unknowns)
    out.set(unknown.name, number_text(to_micrometre(unknown.value)) + " +- " +
                              number_text(to_micrometre(unknown.deviation)) + " " + unknown.unit +
                              (unknown.is_determined ? "" : " (as planned: these views do not tell it)"));
  double worst = 0;
  std::string name;
  for (const plan::CalibratedView& view : found.views)
    if (view.after_mm > worst) {
      worst = view.after_mm;
      name = view.station;
    }
  out.set("views", static_cast<std::uint64_t>(found.views.size()));
  out.set("worst_view", name + ", rms " + number_text(to_micrometre(worst)) + " mm");
  if (!found.without_target.empty()) out.set("views_without_target", texts(found.without_target));
  return out;
}

/// The same for people.
std::string text_of(const std::string& path, const plan::Calibration& found) {
  std::string text = path + ": rms " + number_text(to_micrometre(found.before_mm)) + " -> " +
                     number_text(to_micrometre(found.after_mm)) + " mm over " + counted(found.views.size(), "view") +
                     "\n";
  for (const plan::Unknown& unknown : found.unknowns) {
    text += "  " + unknown.name +
            std::string(std::max<std::size_t>(18, unknown.name.size() + 1) - unknown.name.size(), ' ');
    text += unknown.is_determined ? number_text(to_micrometre(unknown.value)) + " +- " +
                                        number_text(to_micrometre(unknown.deviation)) + " " + unknown.unit + "\n"
                                  : "as planned: these views do not tell it\n";
  }
  for (const std::string& station : found.without_target) text += "  station " + station + " does not see the target\n";
  return text;
}

}  // namespace

Result<ToolReport> calibrate_plans(const CalibrateChoice& choice, const std::string& output, const Context& context,
                                   Progress& progress) {
  ToolReport report;
  std::optional<plan::Calibration> first;
  for (std::size_t night = 0; night < choice.plans.size(); ++night) {
    const std::string& path = choice.plans[night];
    TRY_ASSIGN(plan::ScanPlan plan, load_plan(path));
    TRY_ASSIGN(const plan::CalibrateParams params, params_of(choice, plan, path));
    const std::vector<plan::State> states = plan::settle(plan);
    TRY_ASSIGN(const auto views, views_of(plan, states, path, context, progress));
    auto calibrated = plan::calibrate(*plan.machine, plan.mount, views, params);
    if (!calibrated.ok()) return std::move(calibrated.error()).at(path);
    const plan::Calibration& found = *calibrated;
    Node& row = report.values.set(path, node_of(found));
    report.text += text_of(path, found);
    if (first) {
      const PoseGap drift = gap_between(found.mount.whole(), first->mount.whole());
      row.set("drift_mm", to_micrometre(drift.mm));
      row.set("drift_deg", to_micrometre(drift.degrees));
      report.text += "  drift " + number_text(to_micrometre(drift.mm)) + " mm, " +
                     number_text(to_micrometre(drift.degrees)) + " deg against " + choice.plans.front() + "\n";
    } else {
      first = found;
    }
    if (night + 1 < choice.plans.size() || output.empty()) continue;
    plan.mount = found.mount;
    plan.machine->joints = found.joints;
    // A zero that was moved changes what counts mean, not what was counted.
    for (std::size_t s = 0; s < plan.stations.size(); ++s) {
      plan::Station& station = plan.stations[s];
      if (!states[s].known || station.counts) continue;
      for (const plan::Joint& joint : plan.machine->joints)
        if (plan::counts_per_turn(joint) > 0) station.counts = states[s].counts;
    }
    ToolReport written;
    TRY(hand_over_plan(plan,
                       {"Mount calibrated by scanmill plan calibrate from " + choice.target + " views of " +
                        std::filesystem::path(path).filename().string() + "."},
                       output, written));
    report.values.set("file", output);
    report.text += output + " written\n";
  }
  if (!report.text.empty()) report.text.pop_back();
  progress.stage("calibrate", 1, 1);
  return report;
}

}  // namespace scanmill::pipeline
