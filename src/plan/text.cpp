// SPDX-License-Identifier: Apache-2.0
#include "plan/text.hpp"

#include "document/read_fields.hpp"

namespace scanmill::plan {

using document::Mark;
using document::Node;

namespace {

constexpr std::string_view kPoseKeys[] = {"matrix", "quaternion", "rotation_deg", "translation", "eye", "target", "up"};
constexpr std::string_view kBoxKeys[] = {"low", "high"};

/// -0 becomes 0, so that a pose written and read again is the same to the last bit.
Pose without_negative_zeros(Pose pose) {
  for (double& value : pose.rotation) value += 0.0;
  pose.translation = pose.translation + Vec3{};
  return pose;
}

std::string limits_of(const Field& field) {
  return std::string(field.minimum_excluded ? "(" : "[").append(number_text(field.minimum)) + ", " +
         number_text(field.maximum) + "]";
}

}  // namespace

std::string found(const Node& node) {
  if (node.is_map() || node.is_sequence() || node.is_null()) return node.kind();
  return node.text.empty() ? document::to_json(node) : node.text.substr(0, 60);
}

void Text::problem(Mark mark, const std::string& key, const std::string& what, const std::string& allowed,
                   std::string_view nearest) {
  if (!problems.empty()) problems += '\n';
  problems +=
      document::place(name_, mark) + ": " + (key.empty() ? "" : key + ": ") + "found " + what + "; allowed " + allowed;
  if (!nearest.empty()) problems.append("; nearest ").append(nearest);
}

void Text::check_keys(const Node& map, const std::string& prefix, std::span<const std::string_view> keys) {
  for (const Node::Entry& entry : map.entries()) {
    if (std::find(keys.begin(), keys.end(), entry.key) != keys.end() || entry.key.starts_with("x-")) continue;
    problem(entry.mark, prefix + entry.key, "an unknown key", document::joined(keys), nearest_name(entry.key, keys));
  }
}

std::string Text::text_of(const Node& node, const std::string& key) {
  if (node.is_string()) return node.as_string();
  if (node.is_number() || node.is_bool())
    return node.text.empty() ? document::to_json(node) : node.text;  // a name may be 007
  problem(node.mark, key, found(node), "a text");
  return {};
}

bool Text::assign(const Node& value, const std::string& key, const Field& field, void* object) {
  std::string wanted;
  if (const auto* real = std::get_if<double* (*)(void*)>(&field.member)) {
    if (value.is_number())
      *(*real)(object) = value.as_number();
    else
      wanted = "a number";
  } else if (const auto* maybe = std::get_if<std::optional<double>* (*)(void*)>(&field.member)) {
    if (value.is_number())
      *(*maybe)(object) = value.as_number();
    else if (value.is_null() || (value.is_string() && value.as_string() == "off"))
      (*maybe)(object)->reset();
    else
      wanted = "a number, off";
  } else if (const auto* whole = std::get_if<std::int64_t* (*)(void*)>(&field.member)) {
    if (value.is_integer())
      *(*whole)(object) = value.as_integer();
    else
      wanted = "a whole number";
  } else if (const auto* flag = std::get_if<bool* (*)(void*)>(&field.member)) {
    if (value.is_bool())
      *(*flag)(object) = value.as_bool();
    else
      wanted = "true or false";
  } else if (const auto* word = std::get_if<std::int32_t* (*)(void*)>(&field.member)) {
    const auto at =
        value.is_string() ? std::find(field.words.begin(), field.words.end(), value.as_string()) : field.words.end();
    if (at != field.words.end())
      *(*word)(object) = static_cast<std::int32_t>(at - field.words.begin());
    else
      wanted = document::joined(field.words);
  }
  if (!wanted.empty()) {
    problem(value.mark, key, found(value), wanted,
            value.is_string() ? nearest_name(value.as_string(), field.words) : "");
    return false;
  }
  if (!field.words.empty() || problems_of(std::span<const Field>(&field, 1), object).empty()) return true;
  problem(value.mark, key, found(value), limits_of(field));
  return false;
}

std::vector<double> Text::numbers_of(const Node& node, const std::string& key, std::size_t count) {
  std::vector<double> numbers;
  bool good = node.is_sequence() && node.items().size() == count;
  for (std::size_t i = 0; good && i < count; ++i) {
    good = node.items()[i].is_number() && std::isfinite(node.items()[i].as_number());
    if (good) numbers.push_back(node.items()[i].as_number());
  }
  if (good) return numbers;
  std::string what = found(node);
  if (node.is_sequence()) {
    what = std::string("a list of ").append(std::to_string(node.items().size())).append(" values");
    for (const Node& item : node.items())
      if (!item.is_number() || !std::isfinite(item.as_number())) {
        what.append(", among them ").append(found(item));
        break;
      }
  }
  problem(node.mark, key, what, std::string("a list of ").append(std::to_string(count)).append(" finite numbers"));
  return {};
}

bool Text::read_vector(const Node& node, const std::string& key, Vec3& out) {
  std::array<double, 3> v{};
  if (!read_numbers(node, key, v)) return false;
  out = {v[0], v[1], v[2]};
  return true;
}

Pose Text::read_pose(const Node& node, const std::string& key) {
  const std::string forms = "matrix, quaternion or rotation_deg with translation, or eye with target (and up)";
  if (!node.is_map()) return problem(node.mark, key, found(node), forms), Pose{};
  check_keys(node, key + ".", kPoseKeys);
  const Node* angles = node.find("rotation_deg");
  const int given = (node.find("matrix") != nullptr) + (node.find("quaternion") != nullptr) + (angles != nullptr) +
                    (node.find("eye") != nullptr);
  if (given != 1) return problem(node.mark, key, given == 0 ? "none of them" : "more than one of them", forms), Pose{};
  Pose pose;
  if (const Node* matrix = node.find("matrix"))
    pose = read_matrix(*matrix, key + ".matrix");
  else if (const Node* quaternion = node.find("quaternion"))
    pose = read_quaternion(node, *quaternion, key);
  else if (angles != nullptr)
    pose = read_angles(node, *angles, key);
  else
    pose = read_eye(node, key);
  const Vec3 t = pose.translation;
  if (std::max({std::abs(t.x), std::abs(t.y), std::abs(t.z)}) > 1e12)
    return problem(node.mark, key, "a place more than a million kilometres away", "translations in mm up to 1e+12"),
           Pose{};
  return without_negative_zeros(pose);
}

Pose Text::read_matrix(const Node& node, const std::string& key) {
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

Pose Text::read_quaternion(const Node& node, const Node& quaternion, const std::string& key) {
  std::array<double, 4> q{};
  Vec3 t;
  const Node* translation = node.find("translation");
  bool good = read_numbers(quaternion, key + ".quaternion", q);
  if (translation == nullptr)
    problem(node.mark, key + ".translation", "nothing", "a list of 3 finite numbers");
  else
    good &= read_vector(*translation, key + ".translation", t);
  if (!good || translation == nullptr) return {};
  const auto pose = pose_from_quaternion(q[0], q[1], q[2], q[3], t);
  if (!pose.ok())
    return problem(quaternion.mark, key + ".quaternion", pose.error().message, "x, y, z, w not all zero"), Pose{};
  return *pose;
}

Pose Text::read_angles(const Node& node, const Node& angles, const std::string& key) {
  Vec3 turn, shift;
  bool good = read_vector(angles, key + ".rotation_deg", turn);
  if (const Node* translation = node.find("translation"))
    good &= read_vector(*translation, key + ".translation", shift);
  return good ? pose_from_angles(turn, shift) : Pose{};
}

Pose Text::read_eye(const Node& node, const std::string& key) {
  Vec3 eye, target, up{0, 0, 1};
  const Node* target_node = node.find("target");
  bool good = read_vector(*node.find("eye"), key + ".eye", eye);
  if (target_node == nullptr)
    problem(node.mark, key + ".target", "nothing", "a list of 3 finite numbers");
  else
    good &= read_vector(*target_node, key + ".target", target);
  if (const Node* up_node = node.find("up")) good &= read_vector(*up_node, key + ".up", up);
  if (!good || target_node == nullptr) return {};
  if (eye == target)
    return problem(target_node->mark, key + ".target", "the same place as eye", "another place than eye"), Pose{};
  return pose_looking_at(eye, target, up);
}

Box Text::read_box(const Node& node, const std::string& key) {
  Box box;
  if (!node.is_map()) return problem(node.mark, key, found(node), "a map of low and high"), box;
  check_keys(node, key + ".", kBoxKeys);
  bool good = true;
  for (const std::string_view side : kBoxKeys) {
    const Node* value = node.find(side);
    const std::string name = key + "." + std::string(side);
    if (value == nullptr)
      problem(node.mark, name, "nothing", "a list of 3 finite numbers");
    else
      good &= read_vector(*value, name, side == "low" ? box.low : box.high);
    good &= value != nullptr;
  }
  if (good && !(box.low.x <= box.high.x && box.low.y <= box.high.y && box.low.z <= box.high.z))
    problem(node.mark, key, "a low above its high", "low at or below high on every axis");
  return box;
}

Node triple(Vec3 v) {
  Node list = Node::sequence();
  for (const double value : {v.x, v.y, v.z}) list.push(value);
  return list;
}

Node pose_node(const Pose& pose) {
  Node matrix = Node::sequence();
  for (const double value : pose.matrix()) matrix.push(value);
  Node node = Node::map();
  node.set("matrix", std::move(matrix));
  return node;
}

Node box_node(const Box& box) {
  Node node = Node::map();
  node.set("low", triple(box.low));
  node.set("high", triple(box.high));
  return node;
}

}  // namespace scanmill::plan
