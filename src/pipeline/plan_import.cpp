// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>

#include "base/digest.hpp"
#include "base/text.hpp"
#include "cloud/over_blocks.hpp"
#include "formats/linuxcnc.hpp"
#include "formats/poses.hpp"
#include "formats/probe.hpp"
#include "pipeline/plan_files.hpp"
#include "pipeline/plan_scan.hpp"
#include "pipeline/scan_points.hpp"
#include "pipeline/tool_inputs.hpp"
#include "pipeline/views.hpp"
#include "store/files.hpp"

namespace scanmill::pipeline {
namespace {

namespace fs = std::filesystem;

constexpr const char* kGuesses[] = {"m", "cm", "in", "um"};

/// A file of points with the stem of a pose file, beside it.
std::string neighbour_of(const fs::path& pose_file) {
  std::error_code ignored;
  std::vector<std::string> found;
  for (const auto& entry : fs::directory_iterator(pose_file.parent_path(), ignored)) {
    const std::string suffix = formats::suffix_of(entry.path().filename().string());
    if (entry.path().stem() == pose_file.stem() && entry.path() != pose_file &&
        (formats::is_point_suffix(suffix) || suffix == "3d" || suffix == "png"))
      found.push_back(entry.path().string());
  }
  std::sort(found.begin(), found.end());
  return found.empty() ? std::string() : found.front();
}

class Importing {
 public:
  Importing(const ImportChoice& choice, const std::string& output, const Context& context, Progress& progress)
      : choice_(choice), output_(output), context_(context), progress_(progress) {}

  Result<ToolReport> run(const std::vector<std::string>& inputs) {
    if (inputs.empty()) return fail(Code::BadUsage, "no input file given");
    TRY(take_choice());
    const fs::path first = fs::absolute(inputs.front()).lexically_normal();
    folder_ = output_.empty() ? first.parent_path() : fs::absolute(output_).lexically_normal().parent_path();
    plan_.name = first.stem().string();
    for (const std::string& input : inputs) TRY(take(input));
    TRY(place());
    if (choice_.hash) TRY(add_hashes());
    ToolReport report;
    std::vector<std::string> comments{"Made from " + first.filename().string() +
                                      (inputs.size() > 1 ? " and " + std::to_string(inputs.size() - 1) + " more" : "") +
                                      " by scanmill plan import."};
    comments.insert(comments.end(), notes_.begin(), notes_.end());
    TRY(hand_over_plan(plan_, comments, output_, report));
    report.values.set("stations", static_cast<std::uint64_t>(plan_.stations.size()));
    if (plan_.machine) report.values.set("joints", static_cast<std::uint64_t>(plan_.machine->joints.size()));
    if (!notes_.empty()) report.values.set("notes", texts(notes_));
    return report;
  }

 private:
  struct View {
    std::string file;  // as found; empty: by order
    Pose pose;         // translation in the files' units
  };

  Result<void> take_choice() {
    if (!choice_.machine.empty()) {
      TRY_ASSIGN(plan::ScanPlan other, load_plan(choice_.machine));
      plan_.machine = std::move(other.machine);
      plan_.sensor = other.sensor;
      plan_.has_sensor = other.has_sensor;
      plan_.mount = other.mount;
    }
    if (!choice_.units.empty()) {
      const auto mm = plan::unit_mm(choice_.units);
      if (!mm) return fail(Code::BadUsage, "found '" + choice_.units + "'; allowed mm, cm, m, in, um", "--units");
      plan_.units_mm = *mm;
    }
    if (choice_.every < 1) return fail(Code::BadUsage, "found a number below 1; take 1 or more", "--every");
    if (choice_.intrinsics.empty()) return {};
    std::vector<double> k;
    std::string text = choice_.intrinsics;
    std::replace(text.begin(), text.end(), ',', ' ');
    for (const std::string_view word : words_of(text)) k.push_back(parse_number(word).value_or(NAN));
    if (k.size() != 4 || !std::isfinite(k[0] + k[1] + k[2] + k[3]) || k[0] == 0 || k[1] == 0)
      return fail(Code::BadUsage, "found '" + choice_.intrinsics + "'; wanted fx,fy,cx,cy in pixels", "--intrinsics");
    plan_.camera = plan::Camera{k[0], k[1], k[2], k[3], choice_.depth_scale.value_or(1000)};
    return {};
  }

  Result<void> take(const std::string& input) {
    const fs::path path = fs::absolute(input).lexically_normal();
    const std::string suffix = formats::suffix_of(path.filename().string());
    TRY_ASSIGN(const auto source, store::open_file(input, input));
    if (suffix == "ini") {
      TRY_ASSIGN(const formats::CncMachine machine, formats::read_linuxcnc(*source));
      take_machine(machine);
      return {};
    }
    if (suffix == "pose") {
      TRY_ASSIGN(const Pose pose, formats::read_3dtk_pose(*source));
      plan_.left_handed = true;
      const std::string data = neighbour_of(path);
      if (data.empty())
        return fail(Code::BadInput, "found no file of points named " + path.stem().string() + " beside it", input);
      views_.push_back({data, pose});
      return {};
    }
    TRY_ASSIGN(const formats::Probe kind, formats::probe(*source));
    if (kind.kind == formats::FileKind::Ptx) {
      notes_.push_back(path.filename().string() +
                       " brings the poses of its scans itself; the station adds none to them");
      views_.push_back({path.string(), Pose{}});
      return {};
    }
    TRY_ASSIGN(const std::vector<formats::NamedPose> poses, formats::read_poses(*source));
    const bool named = !poses.front().name.empty();
    const std::string alone = named || poses.size() > 1 || !choice_.files.empty() ? "" : neighbour_of(path);
    for (const formats::NamedPose& pose : poses)
      views_.push_back({named ? (path.parent_path() / pose.name).lexically_normal().string() : alone, pose.pose});
    if (!named && alone.empty() && choice_.files.empty())
      return fail(Code::BadUsage,
                  "holds " + counted(poses.size(), "pose") +
                      " without names of files; say which with --files, a pattern such as 'depth/*.png'",
                  input);
    pattern_folder_ = path.parent_path();
    return {};
  }

  void take_machine(const formats::CncMachine& found) {
    plan::Machine machine = plan_.machine.value_or(plan::Machine{});
    machine.name = found.name;
    machine.joints.clear();
    for (const formats::CncJoint& joint : found.joints) {
      plan::Joint& out = machine.joints.emplace_back();
      out.name = std::string(1, static_cast<char>(joint.letter - 'A' + 'a'));
      out.type = joint.angular ? plan::JointType::Rotary : plan::JointType::Linear;
      const std::size_t axis = std::string_view("XYZABCUVW").find(joint.letter) % 3;
      out.axis = {axis == 0 ? 1.0 : 0, axis == 1 ? 1.0 : 0, axis == 2 ? 1.0 : 0};
      if (joint.low && joint.high) {
        out.low = joint.low;
        out.high = joint.high;
        out.home = std::clamp(joint.home, *joint.low, *joint.high);
      }
      out.velocity = joint.velocity;
      out.acceleration = joint.acceleration;
      out.backlash = joint.backlash;
      if (!joint.counts_per_unit) continue;
      // The file says counts per mm or degree; a turn of 1,000 counts says the same.
      out.counts_per_rev = 1000;
      if (joint.angular)
        out.gear = *joint.counts_per_unit * 360 / 1000;
      else
        out.lead_mm = 1000 / *joint.counts_per_unit;
    }
    plan_.machine = std::move(machine);
    notes_.insert(notes_.end(), found.notes.begin(), found.notes.end());
    notes_.push_back(
        "limits, speeds and counts are the INI file's; directions are those of the letters (A about X, B "
        "about Y, C about Z), everything carries the sensor: say carries: part where a drive moves the "
        "part, and put in origins and sensor.frame");
  }

  /// Data files of poses that come by order.
  Result<void> match_files() {
    if (choice_.files.empty()) return {};
    std::vector<std::string> matched;
    TRY_ASSIGN(const std::vector<std::string> all, store::list_files(pattern_folder_.string()));
    for (const std::string& file : all)
      if (matches_pattern(choice_.files, file)) matched.push_back(file);
    std::sort(matched.begin(), matched.end(), natural_before);
    if (matched.size() != views_.size())
      return fail(Code::BadUsage,
                  counted(matched.size(), "file") + " below " + pattern_folder_.string() + " match '" + choice_.files +
                      "' and there are " + counted(views_.size(), "pose") + "; wanted one each",
                  "--files");
    for (std::size_t i = 0; i < views_.size(); ++i) views_[i].file = (pattern_folder_ / matched[i]).string();
    return {};
  }

  Result<void> place() {
    TRY(match_files());
    std::vector<View> kept;
    for (std::size_t i = 0; i < views_.size(); i += static_cast<std::size_t>(choice_.every)) kept.push_back(views_[i]);
    std::set<std::string> names;
    for (const View& view : kept) {
      plan::Station& station = plan_.stations.emplace_back();
      const fs::path data = fs::path(view.file).lexically_relative(folder_);
      if (data.empty() || !is_inside(data.generic_string()))
        return fail(Code::BadUsage, "the view " + view.file + " does not lie below " + folder_.string() +
                                        ", where the plan is written; write the plan beside or above its views (-o)");
      station.data = data.generic_string();
      station.name = data.stem().string();
      if (!names.insert(station.name).second) names.insert(station.name = station.data);
      station.given_pose = view.pose;
    }
    if (choice_.units.empty() && !plan_.stations.empty()) guess_units();
    for (plan::Station& station : plan_.stations) {
      station.given_pose->translation = station.given_pose->translation * plan_.units_mm;
      station.pose = *station.given_pose;
    }
    return {};
  }

  /// By the size of the first view that is there.
  void guess_units() {
    ScanSpec scan;
    plan::ScanPlan one = plan_;
    one.stations.clear();
    for (const plan::Station& station : plan_.stations)
      if (one.stations.empty() && store::exists((folder_ / station.data).string())) one.stations.push_back(station);
    if (one.stations.empty()) return;
    one.has_sensor = false;
    views_of_plan(one, scan);
    const auto points = ScanPoints::open(folder_.string(), scan, 1);
    if (!points.ok()) return;
    Bounds bounds;
    PointBlock block;
    for (std::size_t b = 0; b < (*points)->block_count(); ++b) {
      if (!(*points)->read_block(b, block).ok()) return;
      for (const Vec3 p : block.positions) bounds.add(p);
    }
    const std::string problem = implausible_size(bounds, 1, 0);
    for (const char* unit : kGuesses) {
      if (problem.find(std::string("set units to ") + unit) == std::string::npos) continue;
      plan_.units_mm = *plan::unit_mm(unit);
      notes_.push_back(std::string("units: ") + unit + " is a guess from the size of " + one.stations.front().data +
                       "; --units says otherwise");
      return;
    }
    notes_.push_back("units: mm is assumed; --units says otherwise");
  }

  Result<void> add_hashes() {
    std::vector<Result<std::string>> digests(plan_.stations.size(), Result<std::string>(std::string()));
    context_.loop.run(digests.size(), [&](std::size_t s, int) {
      if (context_.cancel.is_set()) return;
      const auto file = store::open_file((folder_ / plan_.stations[s].data).string(), plan_.stations[s].data);
      digests[s] = file.ok() ? sha256_of(**file) : Result<std::string>(file.error());
    });
    if (context_.cancel.is_set()) return fail(Code::Cancelled, "stopped while view files were hashed");
    for (std::size_t s = 0; s < digests.size(); ++s) {
      TRY_ASSIGN(plan_.stations[s].sha256, std::move(digests[s]));
    }
    progress_.stage("hash", digests.size(), digests.size());
    return {};
  }

  const ImportChoice& choice_;
  const std::string& output_;
  const Context& context_;
  Progress& progress_;
  plan::ScanPlan plan_;
  std::vector<View> views_;
  std::vector<std::string> notes_;
  fs::path folder_, pattern_folder_;
};

}  // namespace

Result<ToolReport> import_plan(const std::vector<std::string>& inputs, const ImportChoice& choice,
                               const std::string& output, const Context& context, Progress& progress) {
  return Importing(choice, output, context, progress).run(inputs);
}

}  // namespace scanmill::pipeline
