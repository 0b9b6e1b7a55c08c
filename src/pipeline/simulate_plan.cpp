// SPDX-License-Identifier: Apache-2.0
#include "pipeline/simulate_plan.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>

#include "base/digest.hpp"
#include "base/text.hpp"
#include "document/read_fields.hpp"
#include "export/range_maps.hpp"
#include "formats/mesh_reader.hpp"
#include "formats/probe.hpp"
#include "pipeline/fringe_files.hpp"
#include "pipeline/plan_files.hpp"
#include "pipeline/tool_inputs.hpp"
#include "pipeline/views.hpp"
#include "plan/stations.hpp"
#include "simulate/object.hpp"
#include "store/files.hpp"

namespace scanmill::pipeline {
namespace {

using document::Node;
using exporting::RangeFormat;

constexpr std::string_view kSimulated = "scanmill simulate:";  // in the comment of simulated views that have any

/// The solid or mesh to be seen; one of both.
struct Subject {
  std::unique_ptr<simulate::Object> solid;
  std::optional<simulate::RayTree> mesh;
  std::string sha256;  // of the mesh file
};

Result<Subject> subject_of(const std::string& object) {
  Subject subject;
  if (object.find('/') == std::string::npos && object.find('.') == std::string::npos) {
    TRY_ASSIGN(subject.solid, simulate::make_object(object));
    return subject;
  }
  TRY_ASSIGN(const auto source, store::open_file(object, object));
  TRY_ASSIGN(const formats::MeshFile file, formats::read_mesh(source));
  Mesh mesh = formats::mesh_of(file);
  if (file.offset) mesh.offset = *file.offset;
  if (mesh.triangles.empty())
    return fail(Code::BadInput, "the file holds no triangles; name a mesh or a built-in object", object);
  subject.mesh.emplace(mesh);
  TRY_ASSIGN(subject.sha256, sha256_of(*source));
  return subject;
}

bool is_fringes(const std::string& path) { return formats::suffix_of(path) == "fringes"; }
bool can_be_written(const std::string& word) {
  return word == "fringes" || exporting::range_format_of(word).has_value();
}
std::string written_words() { return document::joined(exporting::range_format_words()) + ", fringes"; }

/// Names for the views of stations that have none, and the suffix asked for. True when the plan was changed.
Result<bool> name_views(const SimulateChoice& choice, plan::ScanPlan& plan) {
  if (!choice.format.empty() && !can_be_written(choice.format))
    return fail(Code::BadUsage, "found '" + choice.format + "'; allowed " + written_words(), "--format");
  bool changed = false;
  for (plan::Station& station : plan.stations) {
    if (station.via) continue;
    const std::string was = station.data;
    if (station.data.empty()) {
      station.data = "views/" + station.name + "." + (choice.format.empty() ? "ply" : choice.format);
      if (!is_inside(station.data))
        return fail(Code::BadParameter,
                    "station " + station.name + " has no data file and its name cannot be one; add data", choice.plan);
    } else if (!choice.format.empty()) {
      station.data = std::filesystem::path(station.data).replace_extension(choice.format).string();
    }
    if (!can_be_written(formats::suffix_of(station.data)))
      return fail(Code::BadParameter,
                  "station " + station.name + " has its view in " + station.data + "; this can be written as " +
                      written_words() + "; choose one with --format",
                  choice.plan);
    if (station.data != was) station.sha256.reset();
    changed |= station.data != was;
  }
  return changed;
}

bool has_depth_maps(const plan::ScanPlan& plan) {
  return std::any_of(plan.stations.begin(), plan.stations.end(),
                     [](const plan::Station& station) { return formats::suffix_of(station.data) == "png"; });
}

/// The sensor as a pinhole camera, the farthest depth just within 16 bits.
Result<plan::Camera> camera_of(const plan::ScanPlan& plan, const std::string& place) {
  const scanmill::Sensor& sensor = plan.sensor;
  if (!sensor.perspective)
    return fail(Code::BadParameter, "a sensor with parallel rays leaves no depth maps; choose another --format", place);
  const double nx = static_cast<double>(sensor.pixels_x), ny = static_cast<double>(sensor.pixels_y);
  plan::Camera camera;
  camera.fx = nx * sensor.stand_off_mm / sensor.field_x_mm;
  camera.fy = ny * sensor.stand_off_mm / sensor.field_y_mm;
  camera.cx = nx / 2 - 0.5;
  camera.cy = ny / 2 - 0.5;
  camera.depth_scale = std::floor(65535 / ((sensor.stand_off_mm + sensor.depth_mm) / plan.units_mm));
  return camera;
}

/// keep_out bodies where they are in the global frame at this setting of the machine.
void add_bodies(const plan::ScanPlan& plan, const plan::State& state, simulate::Scene& scene) {
  if (!plan.machine) return;
  const Pose fixed = state.at.part.inverse();            // the machine's frame in the global one
  const Pose deck = plan.machine->part_frame.inverse();  // that of the last joint that carries the part
  for (const plan::KeepOut& body : plan.machine->keep_out)
    scene.add(simulate::Block{body.on == plan::Carries::Part ? deck : fixed, {body.box.low, body.box.high}});
}

Node numbers(const Pose& pose) {
  Node list = Node::sequence();
  for (const double value : pose.matrix()) list.push(Node(value));
  return list;
}

std::string start_of(const std::string& path, std::uint64_t bytes) {
  const auto source = store::open_file(path, path);
  if (!source.ok()) return {};
  std::string start(std::min((*source)->size(), bytes), '\0');
  const auto got = (*source)->read_at(0, start);
  start.resize(got.ok() ? *got : 0);
  return start;
}

/// Simulated views may take the place of views simulated from the same plan, and of nothing else: a plan names the
/// files of real scans. Formats without comments are known by the truth beside them.
Result<void> check_simulated_folder(const std::string& folder, const plan::ScanPlan& plan, const std::string& plan_path,
                                    const std::string& plan_copy, const std::string& plan_text,
                                    const std::string& truth) {
  namespace fs = std::filesystem;
  const char* remedy = "; name another folder with --out, or remove it first; nothing was written";
  if (store::exists(plan_copy) && start_of(plan_copy, kLongestPlan) != plan_text)
    return fail(Code::BadUsage, std::string("is another plan than ") + plan_path + remedy, plan_copy);
  std::error_code error;
  const bool in_its_folder = fs::equivalent(plan_path, plan_copy, error);
  fs::directory_iterator entries(folder, error);  // none when the folder is yet to be made
  for (; !error && !in_its_folder && entries != fs::directory_iterator(); entries.increment(error)) {
    const fs::path path = entries->path();
    const std::string suffix = formats::suffix_of(path.string());
    if (path.filename() == fs::path(plan_copy).filename() || (suffix != "yaml" && suffix != "yml" && suffix != "json"))
      continue;
    if (start_of(path.string(), kLongestPlan).find("scanmill_plan") != std::string::npos)
      return fail(Code::BadUsage, std::string("is another plan, with an archive of its own") + remedy, path.string());
  }
  for (const plan::Station& station : plan.stations) {
    const std::string path = folder + "/" + station.data;
    if (station.via || !store::exists(path)) continue;
    const bool has_comment = formats::suffix_of(path) == "ply";
    if (has_comment ? start_of(path, 1024).find(kSimulated) == std::string::npos : !store::exists(truth))
      return fail(Code::BadUsage, std::string("is there already and was not simulated") + remedy, path);
  }
  return {};
}

class Archive {
 public:
  Archive(const SimulateChoice& choice, const plan::ScanPlan& plan, const Subject& subject)
      : choice_(choice), plan_(plan), subject_(subject), states_(plan::settle(plan)) {}

  Result<void> write_views(const Context& context, Progress& progress) {
    for (std::size_t s = 0; s < plan_.stations.size(); ++s) {
      if (plan_.stations[s].via) continue;
      progress.stage("simulate", s, plan_.stations.size());
      TRY(write_view(s, context));
    }
    progress.stage("simulate", plan_.stations.size(), plan_.stations.size());
    return {};
  }

  Node truth() const {
    Node out = Node::map();
    out.set("scanmill_truth", std::int64_t{1});
    out.set("object", choice_.object);
    if (!subject_.sha256.empty()) out.set("object_sha256", subject_.sha256);
    out.set("seed", choice_.seed);
    out.set("keep_out", choice_.keep_out);
    out.set("sensor", document::fields_to_document(scanmill::Sensor::fields(), &plan_.sensor));
    out.set("effects", document::fields_to_document(simulate::Effects::fields(), &choice_.effects));
    out.set("views", views_);
    return out;
  }
  std::uint64_t points() const { return points_; }
  /// What the user should know of the stations: those that no machine reaches, those that see nothing.
  std::vector<std::string> notes() const {
    std::vector<std::string> all = notes_;
    for (const plan::State& state : states_)
      for (const plan::Finding& finding : state.findings) all.push_back(finding.text);
    return all;
  }
  bool has_range_files() const {
    return std::any_of(plan_.stations.begin(), plan_.stations.end(),
                       [](const plan::Station& station) { return !is_fringes(station.data); });
  }

 private:
  Result<void> write_view(std::size_t s, const Context& context) {
    const plan::Station& station = plan_.stations[s];
    simulate::Scene scene;
    if (subject_.mesh)
      scene.add(*subject_.mesh);
    else
      scene.add(*subject_.solid);
    if (choice_.keep_out) add_bodies(plan_, states_[s], scene);
    const std::uint64_t seed = simulate::view_seed(choice_.seed, s);
    const std::string path = choice_.folder + "/" + station.data;
    TRY(store::make_folders(std::filesystem::path(path).parent_path().string()));
    if (is_fringes(station.data)) return write_fringes(scene, s, seed, path, context);
    TRY_ASSIGN(simulate::RigView view,
               simulate::take_view(scene, plan_.sensor, choice_.effects, station.pose, seed, context));
    for (Vec3& p : view.map.points) {
      p = p * (1 / plan_.units_mm);
      if (plan_.left_handed) p.z = -p.z;
    }
    TRY_ASSIGN(auto sink, store::create_file(path));
    const std::string name = std::filesystem::path(choice_.object).filename().string();
    const std::vector<std::string> comments{std::string(kSimulated) + " object " + name + ", station " + station.name +
                                            ", seed " + std::to_string(choice_.seed)};
    const double scale = plan_.camera ? plan_.camera->depth_scale : 1;
    TRY(exporting::write_range_map(*exporting::range_format_of(formats::suffix_of(station.data)),
                                   {view.map.pixels_x, view.map.pixels_y, view.map.points, scale}, comments, *sink));
    TRY(sink->commit());
    points_ += view.counts.returns;
    if (view.counts.returns == 0)
      notes_.push_back("station " + station.name +
                       " sees nothing: the object is out of its field, depth band or sight");
    Node row = Node::map();
    row.set("name", station.name);
    row.set("data", station.data);
    row.set("pose", numbers(station.pose));
    row.set("true_pose", numbers(view.pose));
    row.set("points", view.counts.returns);
    row.set("around", view.counts.around);
    row.set("outliers", view.counts.outliers);
    row.set("dropped", view.counts.dropped);
    row.set("missing", view.counts.missing);
    row.set("unlit", view.counts.unlit);
    views_.push(std::move(row));
    return {};
  }

  /// Pictures in place of points; of the effects the station's errors alone count.
  Result<void> write_fringes(const simulate::Scene& scene, std::size_t s, std::uint64_t seed, const std::string& path,
                             const Context& context) {
    if (plan_.units_mm != 1 || plan_.left_handed)
      return fail(Code::BadParameter, "fringe pictures are decoded to mm in a right-handed frame; set units: mm",
                  choice_.plan);
    const plan::Station& station = plan_.stations[s];
    simulate::FringeRig rig = choice_.fringes;
    if (choice_.effects.projector_mm != 0) rig.baseline_mm = choice_.effects.projector_mm;
    if (plate_.empty()) {
      TRY_ASSIGN(plate_, simulate::take_plate(plan_.sensor, rig, simulate::view_seed(choice_.seed, ~0ull), context));
    }
    const Pose pose = simulate::displaced(station.pose, choice_.effects, seed);
    TRY_ASSIGN(const auto pictures, simulate::take_fringes(scene, plan_.sensor, rig, pose, seed, context));
    TRY(write_fringe_view(path, rig, plan_.sensor, pictures, plate_));
    Node row = Node::map();
    row.set("name", station.name);
    row.set("data", station.data);
    row.set("pose", numbers(station.pose));
    row.set("true_pose", numbers(pose));
    row.set("pictures", static_cast<std::uint64_t>(pictures.size()));
    views_.push(std::move(row));
    return {};
  }

  const SimulateChoice& choice_;
  const plan::ScanPlan& plan_;
  const Subject& subject_;
  std::vector<plan::State> states_;
  Node views_ = Node::sequence();
  std::vector<fringe::Picture> plate_;
  std::uint64_t points_ = 0;
  std::vector<std::string> notes_;
};

}  // namespace

Result<ToolReport> simulate_plan(const SimulateChoice& choice, const Context& context, Progress& progress) {
  TRY_ASSIGN(const Subject subject, subject_of(choice.object));
  TRY_ASSIGN(const auto source, store::open_file(choice.plan, choice.plan));
  TRY_ASSIGN(const std::string text, read_all(*source, kLongestPlan));
  TRY_ASSIGN(const Node root, document::parse_yaml(text, choice.plan));
  TRY_ASSIGN(plan::ScanPlan plan, plan::plan_from(root, choice.plan));
  if (choice.keep_out && (!plan.machine || plan.machine->keep_out.empty()))
    return fail(Code::BadUsage, "the plan has no keep_out bodies that could stand in view", "--keep-out");
  TRY_ASSIGN(bool changed, name_views(choice, plan));
  if (has_depth_maps(plan) && !plan.camera) {
    TRY_ASSIGN(plan.camera, camera_of(plan, choice.plan));
    changed = true;
  }
  const std::filesystem::path name = std::filesystem::path(choice.plan).filename();
  const std::string plan_copy = choice.folder + "/" + name.string();
  const std::string plan_text = changed ? document::to_yaml(plan::to_document(plan)) : text;
  const std::string truth = choice.folder + "/" + name.stem().string() + ".truth.json";
  TRY(check_simulated_folder(choice.folder, plan, choice.plan, plan_copy, plan_text, truth));
  Archive archive(choice, plan, subject);
  TRY(archive.write_views(context, progress));
  TRY(store::write_text(plan_copy, plan_text));
  TRY(store::write_text(truth, document::to_json(archive.truth(), 1) + "\n"));
  ToolReport report;
  report.values.set("plan", plan_copy);
  report.values.set("truth", truth);
  report.values.set("object", choice.object);
  report.values.set("stations", static_cast<std::uint64_t>(plan.stations.size()));
  if (archive.has_range_files()) report.values.set("points", archive.points());
  if (const std::vector<std::string> notes = archive.notes(); !notes.empty()) report.values.set("notes", texts(notes));
  return report;
}

}  // namespace scanmill::pipeline
