// SPDX-License-Identifier: Apache-2.0
#include "pipeline/propose_plan.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "base/text.hpp"
#include "formats/mesh_reader.hpp"
#include "pipeline/plan_files.hpp"
#include "pipeline/tool_inputs.hpp"
#include "plan/motion.hpp"
#include "plan/propose.hpp"
#include "store/files.hpp"

namespace scanmill::pipeline {
namespace {

Result<Mesh> object_of(const ProposeChoice& choice) {
  if (choice.object.empty() == choice.box.empty())
    return fail(Code::BadUsage, "wanted --object MESH or --box x0,y0,z0,x1,y1,z1, one of them");
  if (!choice.object.empty()) {
    TRY_ASSIGN(const auto source, store::open_file(choice.object, choice.object));
    TRY_ASSIGN(const formats::MeshFile file, formats::read_mesh(source));
    return formats::mesh_of(file);
  }
  std::string text = choice.box;
  std::replace(text.begin(), text.end(), ',', ' ');
  std::vector<double> v;
  for (const std::string_view word : words_of(text)) v.push_back(parse_number(word).value_or(NAN));
  const bool good = v.size() == 6 && v[0] < v[3] && v[1] < v[4] && v[2] < v[5] &&
                    std::isfinite(v[3] - v[0] + v[4] - v[1] + v[5] - v[2]);
  if (!good)
    return fail(Code::BadUsage, "found '" + choice.box + "'; wanted six numbers, low corner before high corner",
                "--box");
  return plan::mesh_of_box({{v[0], v[1], v[2]}, {v[3], v[4], v[5]}});
}

double hundredths(double value) { return std::floor(value * 100 + 0.5) / 100; }

}  // namespace

Result<ToolReport> propose_plan(const std::string& rig, const ProposeChoice& choice, const std::string& output,
                                const Context& context, Progress& progress) {
  TRY_ASSIGN(plan::ScanPlan plan, load_plan(rig));
  if (!plan.has_sensor)
    return fail(Code::BadParameter, "the plan has no sensor; its field and depth band are needed", rig);
  TRY_ASSIGN(const Mesh mesh, object_of(choice));
  Bounds bounds;
  for (const Triangle& t : mesh.triangles)
    for (const std::uint32_t v : t) bounds.add(mesh.positions[v] + mesh.offset);
  if (bounds.empty()) return fail(Code::BadInput, "holds no triangle; wanted a mesh", choice.object);
  const Vec3 size = bounds.size();
  plan.part = plan::Box{bounds.low, bounds.high};
  plan.name = choice.object.empty() ? "box" : std::filesystem::path(choice.object).stem().string();
  progress.stage("propose", 0, 0);
  TRY_ASSIGN(const plan::Surface surface,
             plan::surface_of(mesh, choice.bin_mm.value_or(std::max({size.x, size.y, size.z}) / 50)));
  const plan::ProposeParams params{choice.max_angle_deg, choice.coverage,
                                   static_cast<std::size_t>(choice.max_stations)};
  auto proposal = plan::propose(plan, surface, params, context);
  if (!proposal.ok()) return std::move(proposal.error()).at(rig);
  plan.stations = proposal->stations;
  std::size_t views = 0;
  for (plan::Station& station : plan.stations) {
    if (station.via) continue;
    station.data = "views/" + station.name + ".ply";
    ++views;
  }
  const double share = static_cast<double>(proposal->covered) / static_cast<double>(proposal->visible);
  ToolReport report;
  TRY(hand_over_plan(
      plan,
      {"Stations proposed by scanmill plan propose for " + (choice.object.empty() ? choice.box : choice.object) + ":",
       counted(views, "view") + " see " + number_text(hundredths(100 * share)) + " % of the " +
           grouped(proposal->visible) + " visible bins of " + number_text(surface.bin_mm) + " mm."},
      output, report));
  document::Node& out = report.values;
  out.set("views", static_cast<std::uint64_t>(views));
  out.set("bin_mm", surface.bin_mm);
  out.set("bins", proposal->facets);
  out.set("visible_bins", proposal->visible);
  out.set("covered_bins", proposal->covered);
  out.set("covered_percent", hundredths(100 * share));
  out.set("candidates", proposal->candidates);
  const plan::Replay played = plan::replay(plan);
  if (played.totals.time_s) out.set("time_s", hundredths(*played.totals.time_s));
  out.set("path_mm", hundredths(played.totals.path_mm));
  std::vector<std::string> warnings;
  for (const plan::Step& step : played.steps)
    for (const plan::Finding& finding : step.state.findings) warnings.push_back(finding.text);
  if (!warnings.empty()) out.set("warnings", texts(warnings));
  return report;
}

}  // namespace scanmill::pipeline
