// SPDX-License-Identifier: Apache-2.0
#include "plan/plan.hpp"

#include <set>

#include "document/read_fields.hpp"
#include "plan/stations.hpp"
#include "plan/text.hpp"

namespace scanmill::plan {
namespace {

using document::Node;

struct Unit {
  std::string_view word;
  double mm;
};
constexpr Unit kUnits[] = {{"mm", 1}, {"cm", 10}, {"m", 1000}, {"in", 25.4}, {"um", 0.001}};

constexpr std::string_view kPlanKeys[] = {"scanmill_plan", "name",   "units", "handedness", "camera",
                                          "machine",       "sensor", "part",  "stations"};
constexpr std::string_view kCameraKeys[] = {"intrinsics", "depth_scale"};
constexpr std::string_view kStationKeys[] = {"name", "counts", "joints", "pose", "target", "data", "sha256", "via"};
constexpr std::string_view kTargetKeys[] = {"point", "normal", "stand_off_mm"};
constexpr std::string_view kMountKeys[] = {"frame", "mount_offset", "body"};

/// Walks over the tree once and notes every problem on the way.
class Reader : private Text {
 public:
  explicit Reader(const std::string& name) : Text(name) {}
  using Text::problems;

  ScanPlan read(const Node& root) {
    ScanPlan plan;
    if (!root.is_map()) {
      problem(root.mark, "", found(root), "a map with scanmill_plan: 1 on top");
      return plan;
    }
    check_keys(root, "", kPlanKeys);
    const Node* version = root.find("scanmill_plan");
    if (version == nullptr)
      problem(root.mark, "scanmill_plan", "nothing", "1, the version of the plan's form");
    else if (!version->is_integer() || version->as_integer() != 1)
      problem(version->mark, "scanmill_plan", found(*version), "1");
    if (const Node* name = root.find("name")) plan.name = text_of(*name, "name");
    if (const Node* units = root.find("units")) read_units(*units, plan);
    if (const Node* hand = root.find("handedness")) {
      plan.left_handed = hand->is_string() && hand->as_string() == "left";
      if (!plan.left_handed && !(hand->is_string() && hand->as_string() == "right"))
        problem(hand->mark, "handedness", found(*hand), "right, left");
    }
    if (const Node* camera = root.find("camera")) read_camera(*camera, plan);
    if (const Node* machine = root.find("machine")) plan.machine = read_machine(*machine);
    if (const Node* sensor = root.find("sensor")) read_sensor(*sensor, plan);
    if (const Node* part = root.find("part")) plan.part = read_box(*part, "part");
    const Node* stations = root.find("stations");
    const bool may_be_empty = plan.machine.has_value();  // a machine to be used by other plans
    if (stations == nullptr && !may_be_empty)
      problem(root.mark, "stations", "nothing", "a list of stations");
    else if (stations != nullptr && (!stations->is_sequence() || (stations->items().empty() && !may_be_empty)))
      problem(stations->mark, "stations", found(*stations), "a list of at least one station");
    else if (stations != nullptr)
      read_stations(*stations, plan);
    return plan;
  }

 private:
  void read_units(const Node& node, ScanPlan& plan) {
    std::vector<std::string_view> words;
    for (const Unit& unit : kUnits) words.push_back(unit.word);
    const auto mm = node.is_string() ? unit_mm(node.as_string()) : std::nullopt;
    if (mm)
      plan.units_mm = *mm;
    else
      problem(node.mark, "units", found(node), "mm, cm, m, in, um",
              node.is_string() ? nearest_name(node.as_string(), words) : "");
  }

  void read_camera(const Node& node, ScanPlan& plan) {
    if (!node.is_map()) return problem(node.mark, "camera", found(node), "a map of intrinsics and depth_scale");
    check_keys(node, "camera.", kCameraKeys);
    std::array<double, 4> k{};
    const Node* intrinsics = node.find("intrinsics");
    if (intrinsics == nullptr) return problem(node.mark, "camera.intrinsics", "nothing", "[fx, fy, cx, cy] in pixels");
    if (!read_numbers(*intrinsics, "camera.intrinsics", k)) return;
    if (k[0] == 0 || k[1] == 0)
      problem(intrinsics->mark, "camera.intrinsics", "a focal length of 0",
              "[fx, fy, cx, cy] with fx and fy other than 0");
    plan.camera = Camera{k[0], k[1], k[2], k[3], 1000};
    const Node* scale = node.find("depth_scale");
    if (scale == nullptr) return;
    if (scale->is_number() && scale->as_number() > 0 && std::isfinite(scale->as_number()))
      plan.camera->depth_scale = scale->as_number();
    else
      problem(scale->mark, "camera.depth_scale", found(*scale), "a number above 0: pixel values per unit of length");
  }

  void read_sensor(const Node& node, ScanPlan& plan) {
    if (!node.is_map()) return problem(node.mark, "sensor", found(node), "a map");
    plan.has_sensor = true;
    std::vector<std::string_view> keys;
    for (const Field& field : Sensor::fields()) keys.push_back(field.name);
    keys.insert(keys.end(), std::begin(kMountKeys), std::end(kMountKeys));
    check_keys(node, "sensor.", keys);
    for (const Field& field : Sensor::fields())
      if (const Node* value = node.find(field.name))
        read_field(*value, std::string("sensor.").append(field.name), field, plan.sensor);
    if (const Node* frame = node.find("frame")) plan.mount.frame = read_pose(*frame, "sensor.frame");
    if (const Node* offset = node.find("mount_offset")) plan.mount.offset = read_pose(*offset, "sensor.mount_offset");
    if (const Node* body = node.find("body")) plan.mount.body = read_box(*body, "sensor.body");
  }

  void read_stations(const Node& list, ScanPlan& plan) {
    std::set<std::string> names, files;
    for (std::size_t i = 0; i < list.items().size(); ++i) {
      const Node& node = list.items()[i];
      const std::string prefix = std::string("stations[").append(std::to_string(i)).append("]");
      if (!node.is_map()) {
        problem(node.mark, prefix, found(node), "a map with name, a place and data");
        continue;
      }
      Station station = read_station(node, prefix + ".", plan);
      const Node* name = node.find("name");
      if (!station.name.empty() && !names.insert(station.name).second)
        problem(name->mark, prefix + ".name", station.name + ", the name of an earlier station", "a name of its own");
      if (!station.data.empty() && !files.insert(station.data).second)
        problem(node.find("data")->mark, prefix + ".data", station.data + ", the file of an earlier station",
                "a file of its own");
      plan.stations.push_back(std::move(station));
    }
  }

  Station read_station(const Node& node, const std::string& prefix, const ScanPlan& plan) {
    Station station;
    check_keys(node, prefix, kStationKeys);
    const Node* name = node.find("name");
    if (name != nullptr) station.name = text_of(*name, prefix + "name");
    if (name == nullptr || (name->is_string() && station.name.empty()))
      problem(name == nullptr ? node.mark : name->mark, prefix + "name", "nothing", "a name");
    const Node *pose = node.find("pose"), *counts = node.find("counts"), *joints = node.find("joints"),
               *target = node.find("target");
    if (pose == nullptr && counts == nullptr && joints == nullptr && target == nullptr)
      problem(
          node.mark, prefix + "pose", "nothing",
          "pose (matrix, quaternion or rotation_deg with translation, or eye with target), counts, joints or target");
    if (pose != nullptr) station.given_pose = read_pose(*pose, prefix + "pose");
    if (target != nullptr) station.target = read_target(*target, prefix + "target");
    if (counts != nullptr) read_joint_values(*counts, prefix + "counts", plan, station, true);
    if (joints != nullptr) read_joint_values(*joints, prefix + "joints", plan, station, false);
    if (const Node* data = node.find("data")) read_data(*data, prefix + "data", station);
    if (const Node* via = node.find("via")) {
      if (!via->is_bool())
        problem(via->mark, prefix + "via", found(*via), "true or false");
      else if (via->as_bool() && !station.data.empty())
        problem(via->mark, prefix + "via", "true beside data", "no data at a place that is only passed");
      else
        station.via = via->as_bool();
    }
    if (const Node* sha = node.find("sha256")) read_sha256(*sha, prefix + "sha256", station);
    return station;
  }

  /// A map from joint names to numbers; every joint of the machine has one, or for counts every one that is counted.
  void read_joint_values(const Node& node, const std::string& key, const ScanPlan& plan, Station& station,
                         bool are_counts) {
    if (!plan.machine) return problem(node.mark, key, "them without a machine", "them beside machine only");
    const std::vector<Joint>& joints = plan.machine->joints;
    std::vector<std::string_view> names;
    for (const Joint& joint : joints) names.push_back(joint.name);
    if (!node.is_map()) return problem(node.mark, key, found(node), "a map of " + document::joined(names));
    check_keys(node, key + ".", names);
    std::vector<double> values(joints.size(), 0);
    std::vector<std::int64_t> counts(joints.size(), 0);
    for (std::size_t i = 0; i < joints.size(); ++i) {
      const Node* value = node.find(joints[i].name);
      const std::string name = key + "." + joints[i].name;
      const bool counted = counts_per_turn(joints[i]) > 0;
      if (value == nullptr && (!are_counts || counted))
        problem(node.mark, name, "nothing", are_counts ? "a whole number" : "a number");
      else if (value != nullptr && are_counts && !counted)
        problem(value->mark, name, found(*value),
                "no counts: machine.joints says neither counts_per_rev nor steps_per_rev of " + joints[i].name);
      else if (value != nullptr && are_counts && (!value->is_integer() || std::abs(value->as_number()) > 0x1p53))
        problem(value->mark, name, found(*value), "a whole number");
      else if (value != nullptr && (!value->is_number() || !std::isfinite(value->as_number())))
        problem(value->mark, name, found(*value), "a number");
      else if (value != nullptr && !are_counts && std::abs(value->as_number()) > 1e7)
        problem(value->mark, name, found(*value), "[-1e+07, 1e+07]");
      else if (value != nullptr && are_counts)
        counts[i] = value->as_integer();
      else if (value != nullptr)
        values[i] = value->as_number();
    }
    if (are_counts)
      station.counts = std::move(counts);
    else
      station.joints = std::move(values);
  }

  Target read_target(const Node& node, const std::string& key) {
    Target target{{}, {0, 0, 1}, {}};
    if (!node.is_map()) return problem(node.mark, key, found(node), "a map of point and normal"), target;
    check_keys(node, key + ".", kTargetKeys);
    for (const std::string_view name : {"point", "normal"}) {
      const Node* value = node.find(name);
      Vec3& vector = name == "point" ? target.point : target.normal;
      const std::string place = key + "." + std::string(name);
      if (value == nullptr)
        problem(node.mark, place, "nothing", "a list of 3 finite numbers");
      else if (read_vector(*value, place, vector) && name == "normal") {
        if (!(norm2(vector) > 0))
          problem(value->mark, place, "no direction", "the outward normal of the surface");
        else if (std::abs(norm2(vector) - 1) > 1e-15)
          vector = unit(vector);
      }
    }
    if (const Node* value = node.find("stand_off_mm")) {
      if (value->is_number() && value->as_number() > 0 && value->as_number() <= 1e6)
        target.stand_off_mm = value->as_number();
      else
        problem(value->mark, key + ".stand_off_mm", found(*value), "(0, 1e+06]");
    }
    return target;
  }

  void read_data(const Node& node, const std::string& key, Station& station) {
    std::string file = text_of(node, key);
    while (file.starts_with("./")) file.erase(0, 2);
    if (node.is_string() && !file.empty() && !is_inside(file))
      return problem(node.mark, key, file, "a file inside the folder of the plan");
    station.data = std::move(file);
  }

  void read_sha256(const Node& node, const std::string& key, Station& station) {
    const std::string& text = node.text.empty() && node.is_string() ? node.as_string() : node.text;
    std::string hex;
    for (const char c : text) hex += c >= 'A' && c <= 'F' ? static_cast<char>(c - 'A' + 'a') : c;
    if (hex.size() != 64 || hex.find_first_not_of("0123456789abcdef") != std::string::npos)
      return problem(node.mark, key, found(node), "64 hexadecimal digits");
    station.sha256 = hex;
  }
};

Node station_node(const Station& station, const std::optional<Machine>& machine) {
  Node node = Node::map();
  node.set("name", station.name);
  const auto by_joint = [&](const char* key, const auto& values, bool counted_only) {
    Node& map = node.set(key, Node::map());
    for (std::size_t i = 0; i < values.size(); ++i)
      if (!counted_only || counts_per_turn(machine->joints[i]) > 0) map.set(machine->joints[i].name, values[i]);
  };
  if (station.counts && machine) by_joint("counts", *station.counts, true);
  if (station.joints && machine) by_joint("joints", *station.joints, false);
  if (station.given_pose) node.set("pose", pose_node(*station.given_pose));
  if (!station.given_pose && !station.counts && !station.joints && !station.target)
    node.set("pose", pose_node(station.pose));
  if (station.target) {
    Node& target = node.set("target", Node::map());
    target.set("point", triple(station.target->point));
    target.set("normal", triple(station.target->normal));
    if (station.target->stand_off_mm) target.set("stand_off_mm", *station.target->stand_off_mm);
  }
  if (station.via) node.set("via", true);
  if (!station.data.empty()) node.set("data", station.data);
  if (station.sha256) node.set("sha256", *station.sha256);
  return node;
}

}  // namespace

std::optional<double> unit_mm(std::string_view word) {
  for (const Unit& unit : kUnits)
    if (unit.word == word) return unit.mm;
  return std::nullopt;
}

Result<ScanPlan> plan_from(const Node& root, const std::string& name) {
  Reader reader(name);
  ScanPlan plan = reader.read(root);
  if (!reader.problems.empty()) return fail(Code::BadParameter, reader.problems);
  place_stations(plan);
  return plan;
}

Node to_document(const ScanPlan& plan) {
  Node root = Node::map();
  root.set("scanmill_plan", 1);
  if (!plan.name.empty()) root.set("name", plan.name);
  for (const Unit& unit : kUnits)
    if (unit.mm == plan.units_mm) root.set("units", unit.word);
  if (plan.left_handed) root.set("handedness", "left");
  if (plan.camera) {
    Node intrinsics = Node::sequence();
    for (const double value : {plan.camera->fx, plan.camera->fy, plan.camera->cx, plan.camera->cy})
      intrinsics.push(value);
    Node& camera = root.set("camera", Node::map());
    camera.set("intrinsics", std::move(intrinsics));
    camera.set("depth_scale", plan.camera->depth_scale);
  }
  if (plan.machine) root.set("machine", machine_node(*plan.machine));
  const bool mounted = !(plan.mount.frame == Pose{}) || !(plan.mount.offset == Pose{}) || plan.mount.body;
  if (plan.has_sensor || mounted) {
    Node& node = root.set("sensor", document::fields_to_document(Sensor::fields(), &plan.sensor));
    if (!(plan.mount.frame == Pose{})) node.set("frame", pose_node(plan.mount.frame));
    if (!(plan.mount.offset == Pose{})) node.set("mount_offset", pose_node(plan.mount.offset));
    if (plan.mount.body) node.set("body", box_node(*plan.mount.body));
  }
  if (plan.part) root.set("part", box_node(*plan.part));
  Node& stations = root.set("stations", Node::sequence());
  for (const Station& station : plan.stations) stations.push(station_node(station, plan.machine));
  return root;
}

}  // namespace scanmill::plan
