// SPDX-License-Identifier: Apache-2.0
#include "pipeline/plan_scan.hpp"

#include "pipeline/views.hpp"
#include "plan/accuracy.hpp"
#include "plan/motion.hpp"
#include "plan/stations.hpp"

namespace scanmill::pipeline {

std::string folder_of(const std::string& path) {
  const auto slash = path.rfind('/');
  return slash == std::string::npos ? std::string() : path.substr(0, slash + 1);
}

void views_of_plan(const plan::ScanPlan& plan, ScanSpec& scan) {
  scan.units_mm = plan.units_mm;
  if (plan.has_sensor) scan.sensor = plan.sensor;
  if (const auto accuracy = plan::accuracy_of(plan))
    scan.accuracy = refine::Accuracy{accuracy->shift_mm, accuracy->turn_deg};
  if (plan.machine)
    for (const plan::KeepOut& body : plan.machine->keep_out)
      if (body.on == plan::Carries::Part)
        scan.datums.push_back({plan.machine->part_frame.inverse(), {body.box.low, body.box.high}});
  for (const plan::Station& station : plan.stations) {
    if (station.via) continue;
    if (station.data.empty()) {
      scan.notes.push_back("station " + station.name + " names no data file and was passed over");
      continue;
    }
    ViewSpec& view = scan.views.emplace_back();
    view.path = plain_path(folder_of(scan.description) + station.data);
    view.pose = station.pose;
    view.station = station.name;
    view.mirrored = plan.left_handed;
    if (const auto& c = plan.camera) view.camera = formats::DepthCamera{c->fx, c->fy, c->cx, c->cy, c->depth_scale};
    view.expected_sha256 = station.sha256.value_or("");
    if (plan.has_sensor && plan.sensor.perspective)
      view.view_point.eye = Vec3{0, 0, 0};
    else if (plan.has_sensor)
      view.view_point.direction = Vec3{0, 0, -1};
  }
}

void judge_plan(const plan::ScanPlan& plan, ScanSpec& scan) {
  for (const plan::Step& step : plan::replay(plan).steps)  // the ways between stations too
    for (const plan::Finding& finding : step.state.findings)
      if (finding.severity == plan::Severity::Warning)
        scan.notes.push_back(finding.text);
      else
        scan.broken += (scan.broken.empty() ? "" : "\n") + scan.description + ": " + finding.text;
}

}  // namespace scanmill::pipeline
