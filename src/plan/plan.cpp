// SPDX-License-Identifier: Apache-2.0
#include "plan/plan.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "base/text.hpp"

namespace scanmill::plan {
namespace {

using document::Mark;
using document::Node;

struct Unit {
  std::string_view word;
  double mm;
};
constexpr Unit kUnits[] = {{"mm", 1}, {"cm", 10}, {"m", 1000}, {"in", 25.4}, {"um", 0.001}};

constexpr std::string_view kPlanKeys[] = {"scanmill_plan", "name", "units", "sensor", "stations"};
constexpr std::string_view kStationKeys[] = {"name", "pose", "data", "sha256"};
constexpr std::string_view kPoseKeys[] = {"matrix", "quaternion", "translation", "eye", "target", "up"};

/// A value for a message: as written, or what kind of thing it is.
std::string found(const Node& node) {
  if (node.is_map() || node.is_sequence() || node.is_null()) return node.kind();
  return node.text.empty() ? document::to_json(node) : node.text.substr(0, 60);
}

/// -0 becomes 0, so that a pose written and read again is the same to the last bit.
Pose without_negative_zeros(Pose pose) {
  for (double& value : pose.rotation) value += 0.0;
  pose.translation = pose.translation + Vec3{};
  return pose;
}

/// Walks over the tree once and notes every problem on the way.
class Reader {
 public:
  explicit Reader(const std::string& name) : name_(name) {}

  std::string problems;

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
    if (const Node* sensor = root.find("sensor")) read_sensor(*sensor, plan);
    const Node* stations = root.find("stations");
    if (stations == nullptr)
      problem(root.mark, "stations", "nothing", "a list of stations");
    else if (!stations->is_sequence() || stations->items().empty())
      problem(stations->mark, "stations", found(*stations), "a list of at least one station");
    else
      read_stations(*stations, plan);
    return plan;
  }

 private:
  void problem(Mark mark, const std::string& key, const std::string& what, const std::string& allowed,
               std::string_view nearest = {}) {
    if (!problems.empty()) problems += '\n';
    problems += document::place(name_, mark) + ": " + (key.empty() ? "" : key + ": ") + "found " + what + "; allowed " +
                allowed;
    if (!nearest.empty()) problems.append("; nearest ").append(nearest);
  }

  void check_keys(const Node& map, const std::string& prefix, std::span<const std::string_view> keys) {
    std::string list;
    for (const std::string_view key : keys) {
      if (!list.empty()) list += ", ";
      list += key;
    }
    for (const Node::Entry& entry : map.entries()) {
      if (std::find(keys.begin(), keys.end(), entry.key) != keys.end()) continue;
      problem(entry.mark, prefix + entry.key, "an unknown key", list, nearest_name(entry.key, keys));
    }
  }

  std::string text_of(const Node& node, const std::string& key) {
    if (node.is_string()) return node.as_string();
    if (node.is_number() || node.is_bool())
      return node.text.empty() ? document::to_json(node) : node.text;  // a name may be 007
    problem(node.mark, key, found(node), "a text");
    return {};
  }

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

  void read_sensor(const Node& node, ScanPlan& plan) {
    if (!node.is_map()) return problem(node.mark, "sensor", found(node), "a map");
    plan.has_sensor = true;
    std::vector<std::string_view> keys;
    for (const Field& field : Sensor::fields()) keys.push_back(field.name);
    check_keys(node, "sensor.", keys);
    for (const Field& field : Sensor::fields())
      if (const Node* value = node.find(field.name)) read_field(*value, field, plan.sensor);
  }

  void read_field(const Node& value, const Field& field, Sensor& sensor) {
    const std::string key = std::string("sensor.").append(field.name);
    Sensor trial = sensor;
    const char* wanted = nullptr;
    if (const auto* real = std::get_if<double* (*)(void*)>(&field.member)) {
      if (value.is_number())
        *(*real)(&trial) = value.as_number();
      else
        wanted = "a number";
    } else if (const auto* whole = std::get_if<std::int64_t* (*)(void*)>(&field.member)) {
      if (value.is_integer())
        *(*whole)(&trial) = value.as_integer();
      else
        wanted = "a whole number";
    } else if (const auto* flag = std::get_if<bool* (*)(void*)>(&field.member)) {
      if (value.is_bool())
        *(*flag)(&trial) = value.as_bool();
      else
        wanted = "true or false";
    }
    if (wanted != nullptr) return problem(value.mark, key, found(value), wanted);
    if (!problems_of(std::span<const Field>(&field, 1), &trial).empty())
      return problem(value.mark, key, found(value),
                     std::string(field.minimum_excluded ? "(" : "[").append(number_text(field.minimum)) + ", " +
                         number_text(field.maximum) + "]");
    sensor = trial;
  }

  void read_stations(const Node& list, ScanPlan& plan) {
    std::set<std::string> names, files;
    for (std::size_t i = 0; i < list.items().size(); ++i) {
      const Node& node = list.items()[i];
      const std::string prefix = std::string("stations[").append(std::to_string(i)).append("]");
      if (!node.is_map()) {
        problem(node.mark, prefix, found(node), "a map with name, pose and data");
        continue;
      }
      Station station = read_station(node, prefix + ".");
      const Node* name = node.find("name");
      if (!station.name.empty() && !names.insert(station.name).second)
        problem(name->mark, prefix + ".name", station.name + ", the name of an earlier station", "a name of its own");
      if (!station.data.empty() && !files.insert(station.data).second)
        problem(node.find("data")->mark, prefix + ".data", station.data + ", the file of an earlier station",
                "a file of its own");
      plan.stations.push_back(std::move(station));
    }
  }

  Station read_station(const Node& node, const std::string& prefix) {
    Station station;
    check_keys(node, prefix, kStationKeys);
    const Node* name = node.find("name");
    if (name != nullptr) station.name = text_of(*name, prefix + "name");
    if (name == nullptr || (name->is_string() && station.name.empty()))
      problem(name == nullptr ? node.mark : name->mark, prefix + "name", "nothing", "a name");
    const Node* pose = node.find("pose");
    if (pose == nullptr)
      problem(node.mark, prefix + "pose", "nothing", "matrix, quaternion with translation, or eye with target");
    else
      station.pose = without_negative_zeros(read_pose(*pose, prefix + "pose"));
    if (const Node* data = node.find("data")) read_data(*data, prefix + "data", station);
    if (const Node* sha = node.find("sha256")) read_sha256(*sha, prefix + "sha256", station);
    return station;
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

  /// N finite numbers; false with a problem noted otherwise.
  template <std::size_t N>
  bool read_numbers(const Node& node, const std::string& key, std::array<double, N>& out) {
    bool good = node.is_sequence() && node.items().size() == N;
    for (std::size_t i = 0; good && i < N; ++i) {
      good = node.items()[i].is_number() && std::isfinite(node.items()[i].as_number());
      if (good) out[i] = node.items()[i].as_number();
    }
    if (good) return true;
    std::string what = found(node);
    if (node.is_sequence()) {
      what = std::string("a list of ").append(std::to_string(node.items().size())).append(" values");
      for (const Node& item : node.items())
        if (!item.is_number() || !std::isfinite(item.as_number())) {
          what.append(", among them ").append(found(item));
          break;
        }
    }
    problem(node.mark, key, what, std::string("a list of ").append(std::to_string(N)).append(" finite numbers"));
    return false;
  }

  Pose read_pose(const Node& node, const std::string& key) {
    const std::string forms = "matrix, quaternion with translation, or eye with target (and up)";
    if (!node.is_map()) return problem(node.mark, key, found(node), forms), Pose{};
    check_keys(node, key + ".", kPoseKeys);
    const int given =
        (node.find("matrix") != nullptr) + (node.find("quaternion") != nullptr) + (node.find("eye") != nullptr);
    if (given != 1)
      return problem(node.mark, key, given == 0 ? "none of them" : "more than one of them", forms), Pose{};
    if (const Node* matrix = node.find("matrix")) return read_matrix(*matrix, key + ".matrix");
    if (const Node* quaternion = node.find("quaternion")) return read_quaternion(node, *quaternion, key);
    return read_eye(node, key);
  }

  Pose read_matrix(const Node& node, const std::string& key) {
    std::array<double, 16> m{};
    if (!read_numbers(node, key, m)) return {};
    const auto pose = pose_from_matrix(m);
    if (!pose.ok()) return problem(node.mark, key, pose.error().message, "a row-major rigid 4x4 matrix"), Pose{};
    // A rotation that is right to rounding is kept as written: taking it apart again would move its last bits.
    Pose verbatim;
    verbatim.rotation = {m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10]};
    verbatim.translation = pose->translation;
    double off = 0;
    for (std::size_t i = 0; i < 9; ++i) off = std::max(off, std::abs(verbatim.rotation[i] - pose->rotation[i]));
    return off <= 1e-14 ? verbatim : *pose;
  }

  Pose read_quaternion(const Node& node, const Node& quaternion, const std::string& key) {
    std::array<double, 4> q{};
    std::array<double, 3> t{};
    const Node* translation = node.find("translation");
    bool good = read_numbers(quaternion, key + ".quaternion", q);
    if (translation == nullptr)
      problem(node.mark, key + ".translation", "nothing", "a list of 3 finite numbers");
    else
      good &= read_numbers(*translation, key + ".translation", t);
    if (!good || translation == nullptr) return {};
    const auto pose = pose_from_quaternion(q[0], q[1], q[2], q[3], {t[0], t[1], t[2]});
    if (!pose.ok())
      return problem(quaternion.mark, key + ".quaternion", pose.error().message, "x, y, z, w not all zero"), Pose{};
    return *pose;
  }

  Pose read_eye(const Node& node, const std::string& key) {
    std::array<double, 3> eye{}, target{}, up{0, 0, 1};
    const Node* target_node = node.find("target");
    bool good = read_numbers(*node.find("eye"), key + ".eye", eye);
    if (target_node == nullptr)
      problem(node.mark, key + ".target", "nothing", "a list of 3 finite numbers");
    else
      good &= read_numbers(*target_node, key + ".target", target);
    if (const Node* up_node = node.find("up")) good &= read_numbers(*up_node, key + ".up", up);
    if (!good || target_node == nullptr) return {};
    if (eye == target)
      return problem(target_node->mark, key + ".target", "the same place as eye", "another place than eye"), Pose{};
    return pose_looking_at({eye[0], eye[1], eye[2]}, {target[0], target[1], target[2]}, {up[0], up[1], up[2]});
  }

  const std::string& name_;
};

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
  return plan;
}

Node to_document(const ScanPlan& plan) {
  Node root = Node::map();
  root.set("scanmill_plan", 1);
  if (!plan.name.empty()) root.set("name", plan.name);
  for (const Unit& unit : kUnits)
    if (unit.mm == plan.units_mm) root.set("units", unit.word);
  if (plan.has_sensor) {
    Sensor sensor = plan.sensor;
    Node& node = root.set("sensor", Node::map());
    for (const Field& field : Sensor::fields()) {
      if (const auto* real = std::get_if<double* (*)(void*)>(&field.member))
        node.set(field.name, *(*real)(&sensor));
      else if (const auto* whole = std::get_if<std::int64_t* (*)(void*)>(&field.member))
        node.set(field.name, *(*whole)(&sensor));
      else if (const auto* flag = std::get_if<bool* (*)(void*)>(&field.member))
        node.set(field.name, *(*flag)(&sensor));
    }
  }
  Node& stations = root.set("stations", Node::sequence());
  for (const Station& station : plan.stations) {
    Node node = Node::map();
    node.set("name", station.name);
    Node matrix = Node::sequence();
    for (const double value : station.pose.matrix()) matrix.push(value);
    node.set("pose", Node::map()).set("matrix", std::move(matrix));
    if (!station.data.empty()) node.set("data", station.data);
    if (station.sha256) node.set("sha256", *station.sha256);
    stations.push(std::move(node));
  }
  return root;
}

}  // namespace scanmill::plan
