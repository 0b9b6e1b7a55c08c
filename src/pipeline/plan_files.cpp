// SPDX-License-Identifier: Apache-2.0
#include "pipeline/plan_files.hpp"

#include <filesystem>

#include "base/text.hpp"
#include "export/poses.hpp"
#include "pipeline/tool_inputs.hpp"
#include "plan/motion.hpp"
#include "store/files.hpp"

namespace scanmill::pipeline {
namespace {

constexpr std::string_view kExports[] = {"gcode", "conf", "aln", "log", "xf", "3dtk"};

/// To the terminal as it is, under --json as a value.
void hand_over_text(std::string text, ToolReport& report) {
  report.values.set("text", text);
  while (!text.empty() && text.back() == '\n') text.pop_back();
  report.text = std::move(text);
}

/// Moves in the words of RS-274: absolute, mm, one rapid move per station.
Result<std::string> gcode_of(const plan::ScanPlan& plan) {
  if (!plan.machine || plan.machine->joints.empty())
    return fail(Code::BadParameter, "the plan has no machine with joints; G-code needs one");
  const plan::Machine& machine = *plan.machine;
  for (const plan::Joint& joint : machine.joints)
    if (joint.name.size() != 1 || std::string_view("xyzabcuvwXYZABCUVW").find(joint.name[0]) == std::string_view::npos)
      return fail(Code::BadParameter, "joint " + joint.name + " is no letter of G-code; allowed x y z a b c u v w");
  const plan::Replay played = plan::replay(plan);
  std::string text = "; " + (plan.name.empty() ? std::string("scan plan") : plan.name) + " on " + machine.name +
                     ", made by scanmill plan export\nG21 ; mm\nG90 ; absolute\n";
  for (std::size_t s = 0; s < plan.stations.size(); ++s) {
    const plan::State& state = played.steps[s].state;
    if (!state.known) return fail(Code::BadParameter, state.findings.empty() ? "" : state.findings.front().text);
    std::string move = "G0";
    for (std::size_t i = 0; i < machine.joints.size(); ++i) {
      const plan::Joint& joint = machine.joints[i];
      const char letter = joint.name[0] >= 'a' ? static_cast<char>(joint.name[0] - 'a' + 'A') : joint.name[0];
      // What the controller is told: the shaft's place. Lost motion is the machine's, as in the counts.
      const double shaft =
          plan::counts_per_turn(joint) > 0 ? plan::value_of(joint, state.counts[i], 1) : state.joints[i];
      move += std::string(" ") + letter + plan::rounded(shaft);
    }
    text += move + " ; station " + plan.stations[s].name + "\n";
    if (plan.stations[s].via) continue;
    if (machine.dwell_s > 0)
      text += "G4 P" + number_text(machine.dwell_s) + " ; view\n";
    else
      text += "M0 ; view\n";
  }
  return text + "M2\n";
}

std::vector<exporting::PosedFile> posed_files(const plan::ScanPlan& plan) {
  std::vector<exporting::PosedFile> files;
  for (const plan::Station& station : plan.stations) {
    if (station.via) continue;
    Pose pose = station.pose;
    pose.translation = pose.translation * (1 / plan.units_mm);
    files.push_back({station.data.empty() ? station.name : station.data, pose});
  }
  return files;
}

Result<ToolReport> export_3dtk(const plan::ScanPlan& plan, const std::string& folder) {
  if (folder.empty()) return fail(Code::BadUsage, "3dtk writes one .pose per view; name a folder with -o");
  TRY(store::make_folders(folder));
  const auto files = posed_files(plan);
  for (std::size_t i = 0; i < files.size(); ++i) {
    std::string number = std::to_string(i);
    number.insert(0, number.size() < 3 ? 3 - number.size() : 0, '0');
    TRY(store::write_text(folder + "/scan" + number + ".pose", exporting::dtk_text(files[i].pose)));
  }
  ToolReport report;
  report.values.set("folder", folder);
  report.values.set("poses", static_cast<std::uint64_t>(files.size()));
  if (!plan.left_handed)
    report.values.set("notes", texts({"3DTK frames are left-handed: negate z of the points that go with these poses"}));
  return report;
}

}  // namespace

Result<plan::ScanPlan> load_plan(const std::string& path) {
  const auto source = store::open_file(path, path);
  if (!source.ok()) return fail(Code::BadParameter, source.error().message, source.error().where);
  TRY_ASSIGN(const std::string text, read_all(**source, kLongestPlan));
  TRY_ASSIGN(const document::Node root, document::parse_yaml(text, path));
  return plan::plan_from(root, path);
}

Result<void> hand_over_plan(const plan::ScanPlan& plan, const std::vector<std::string>& comments,
                            const std::string& output, ToolReport& report) {
  std::string text;
  for (const std::string& line : comments) text += "# " + line + "\n";
  text += document::to_yaml(plan::to_document(plan));
  if (output.empty()) {
    hand_over_text(std::move(text), report);
    return {};
  }
  TRY(store::write_text(output, text));
  report.values.set("file", output);
  return {};
}

Result<ToolReport> export_plan(const std::string& path, const std::string& as, const std::string& output) {
  TRY_ASSIGN(const plan::ScanPlan plan, load_plan(path));
  if (plan.stations.empty())
    return fail(Code::BadParameter, "the plan has no stations; there is nothing to export", path);
  std::string text;
  if (as == "gcode") {
    auto code = gcode_of(plan);
    if (!code.ok()) return std::move(code.error()).at(path);
    text = std::move(code).value();
  } else if (as == "conf") {
    auto conf = exporting::conf_text(posed_files(plan));
    if (!conf.ok()) return std::move(conf.error()).at(path);
    text = std::move(conf).value();
  } else if (as == "aln") {
    text = exporting::aln_text(posed_files(plan));
  } else if (as == "log") {
    text = exporting::log_text(posed_files(plan));
  } else if (as == "xf") {
    text = exporting::matrices_text(posed_files(plan));
  } else if (as == "3dtk") {
    return export_3dtk(plan, output);
  } else {
    const std::string_view nearest = nearest_name(as, kExports);
    return fail(Code::BadUsage,
                "found '" + as + "'; allowed gcode, conf, aln, log, xf, 3dtk" +
                    (nearest.empty() ? "" : "; nearest " + std::string(nearest)),
                "--as");
  }
  ToolReport report;
  report.values.set("stations", static_cast<std::uint64_t>(plan.stations.size()));
  if (output.empty()) {
    hand_over_text(std::move(text), report);
    return report;
  }
  TRY(store::write_text(output, text));
  report.values.set("file", output);
  return report;
}

Result<ToolReport> solve_plan(const std::string& path, const std::string& machine, const std::string& output) {
  TRY_ASSIGN(plan::ScanPlan plan, load_plan(path));
  if (!machine.empty()) {
    TRY_ASSIGN(plan::ScanPlan other, load_plan(machine));
    plan.machine = std::move(other.machine);
    plan.mount = other.mount;
    if (other.has_sensor) {
      plan.sensor = other.sensor;
      plan.has_sensor = true;
    }
  }
  if (!plan.machine || plan.machine->joints.empty())
    return fail(Code::BadParameter,
                "the plan has no machine with joints; add one, or name a plan that has with --machine", path);
  const plan::Replay played = plan::replay(plan);
  std::string errors;
  ToolReport report;
  document::Node rows = document::Node::map();
  std::vector<std::string> warnings;
  for (std::size_t s = 0; s < plan.stations.size(); ++s) {
    const plan::State& state = played.steps[s].state;
    plan::Station& station = plan.stations[s];
    for (const plan::Finding& finding : state.findings)
      if (finding.severity == plan::Severity::Error)
        errors += (errors.empty() ? "" : "\n") + path + ": " + finding.text;
      else
        warnings.push_back(finding.text);
    if (!state.known) continue;
    document::Node& row = rows.set(station.name, document::Node::map());
    for (std::size_t i = 0; i < plan.machine->joints.size(); ++i)
      row.set(plan.machine->joints[i].name, plan::rounded(state.joints[i]) + " " +
                                                plan::unit_of(plan.machine->joints[i]) + ", " +
                                                plan::rounded(state.turns[i]) + " turns");
    bool counted = false;
    for (const plan::Joint& joint : plan.machine->joints) counted |= plan::counts_per_turn(joint) > 0;
    if (counted && !station.counts) station.counts = state.counts;
    station.joints = state.joints;
    station.given_pose.reset();
    station.target.reset();
  }
  if (!errors.empty()) return fail(Code::BadParameter, errors);
  TRY(hand_over_plan(plan,
                     {"Joints and counts worked out by scanmill plan solve from " +
                      std::filesystem::path(path).filename().string() + "."},
                     output, report));
  report.values.set("stations", static_cast<std::uint64_t>(plan.stations.size()));
  report.values.set("solved", std::move(rows));
  if (!warnings.empty()) report.values.set("warnings", texts(warnings));
  return report;
}

}  // namespace scanmill::pipeline
