// SPDX-License-Identifier: Apache-2.0
// The machine of a plan from its text and back.
#include <set>

#include "document/read_fields.hpp"
#include "plan/text.hpp"

namespace scanmill::plan {

using document::Node;

namespace {

constexpr std::string_view kMachineKeys[] = {"name", "joints", "part_frame", "keep_out"};
constexpr std::string_view kJointKeys[] = {"name", "axis", "origin", "limits"};
constexpr std::string_view kKeepOutKeys[] = {"name", "low", "high", "on"};

std::vector<std::string_view> with_fields(std::span<const std::string_view> keys, std::span<const Field> fields) {
  std::vector<std::string_view> all(keys.begin(), keys.end());
  for (const Field& field : fields) all.push_back(field.name);
  return all;
}

Node without_empty(std::span<const Field> fields, const void* object) {
  Node map = document::fields_to_document(fields, object);
  std::erase_if(map.entries(), [](const Node::Entry& entry) { return entry.value.is_null(); });
  return map;
}

}  // namespace

Machine Text::read_machine(const Node& node) {
  Machine machine;
  if (!node.is_map()) return problem(node.mark, "machine", found(node), "a map with joints"), machine;
  check_keys(node, "machine.", with_fields(kMachineKeys, Machine::fields()));
  if (const Node* name = node.find("name")) machine.name = text_of(*name, "machine.name");
  for (const Field& field : Machine::fields())
    if (const Node* value = node.find(field.name))
      read_field(*value, "machine." + std::string(field.name), field, machine);
  if (const Node* frame = node.find("part_frame")) machine.part_frame = read_pose(*frame, "machine.part_frame");
  const Node* joints = node.find("joints");
  if (joints == nullptr || !joints->is_sequence()) {
    problem(joints == nullptr ? node.mark : joints->mark, "machine.joints",
            joints == nullptr ? "nothing" : found(*joints),
            "a list of joints in chain order; [] for a machine that does not move");
    return machine;
  }
  std::set<std::string> names;
  for (std::size_t i = 0; i < joints->items().size(); ++i) {
    const Node& item = joints->items()[i];
    machine.joints.push_back(read_joint(item, "machine.joints[" + std::to_string(i) + "]"));
    const std::string& name = machine.joints.back().name;
    if (!name.empty() && !names.insert(name).second)
      problem(item.mark, "machine.joints[" + std::to_string(i) + "].name", name + ", the name of an earlier joint",
              "a name of its own");
  }
  if (const Node* list = node.find("keep_out")) {
    if (!list->is_sequence()) return problem(list->mark, "machine.keep_out", found(*list), "a list of boxes"), machine;
    for (std::size_t i = 0; i < list->items().size(); ++i)
      machine.keep_out.push_back(read_keep_out(list->items()[i], "machine.keep_out[" + std::to_string(i) + "]"));
  }
  return machine;
}

Joint Text::read_joint(const Node& node, const std::string& key) {
  Joint joint;
  if (!node.is_map()) return problem(node.mark, key, found(node), "a map with name, type and axis"), joint;
  check_keys(node, key + ".", with_fields(kJointKeys, Joint::fields()));
  const Node* name = node.find("name");
  if (name != nullptr) joint.name = text_of(*name, key + ".name");
  if (joint.name.empty()) problem(node.mark, key + ".name", "nothing", "a name such as x");
  if (node.find("type") == nullptr) problem(node.mark, key + ".type", "nothing", "linear, rotary");
  for (const Field& field : Joint::fields())
    if (const Node* value = node.find(field.name))
      read_field(*value, key + "." + std::string(field.name), field, joint);
  const Node* axis = node.find("axis");
  if (axis == nullptr) {
    problem(node.mark, key + ".axis", "nothing", "a direction such as [1, 0, 0]");
  } else if (read_vector(*axis, key + ".axis", joint.axis)) {
    // A unit vector is kept as written: scaling it again would move its last bits.
    if (norm2(joint.axis) > 0)
      joint.axis = std::abs(norm2(joint.axis) - 1) <= 1e-15 ? joint.axis : unit(joint.axis);
    else
      problem(axis->mark, key + ".axis", "no direction", "a direction such as [1, 0, 0]");
  }
  if (const Node* origin = node.find("origin")) read_vector(*origin, key + ".origin", joint.origin);
  if (const Node* limits = node.find("limits")) {
    std::array<double, 2> ends{};
    if (read_numbers(*limits, key + ".limits", ends)) {
      if (std::abs(ends[0]) > 1e6 || std::abs(ends[1]) > 1e6)
        problem(limits->mark, key + ".limits", "a limit beyond a million", "[low, high] within -1e+06 and 1e+06");
      else if (ends[0] > ends[1])
        problem(limits->mark, key + ".limits", "a low limit above the high one", "[low, high]");
      joint.low = ends[0];
      joint.high = ends[1];
    }
  }
  check_joint(joint, node, key);
  return joint;
}

void Text::check_joint(const Joint& joint, const Node& node, const std::string& key) {
  const bool linear = joint.type == JointType::Linear, counted = counts_per_turn(joint) > 0;
  if (linear && counted && !(joint.lead_mm > 0))
    problem(node.mark, key + ".lead_mm", "nothing", "mm per turn of the screw, wanted with counts or steps");
  if (!linear && joint.lead_mm > 0)
    problem(node.find("lead_mm")->mark, key + ".lead_mm", number_text(joint.lead_mm) + " on a rotary joint",
            "no lead; gear says how many turns of the motor make one of the joint");
  if (joint.low && (joint.home < *joint.low || joint.home > *joint.high))
    problem(node.mark, key + ".home", number_text(joint.home),
            "a place within limits [" + number_text(*joint.low) + ", " + number_text(*joint.high) + "]");
}

KeepOut Text::read_keep_out(const Node& node, const std::string& key) {
  KeepOut body;
  if (!node.is_map()) return problem(node.mark, key, found(node), "a map of name, low and high"), body;
  check_keys(node, key + ".", kKeepOutKeys);
  if (const Node* name = node.find("name")) body.name = text_of(*name, key + ".name");
  if (const Node* on = node.find("on")) {
    const std::string word = on->is_string() ? on->as_string() : std::string();
    if (word == "machine")
      body.on = Carries::Sensor;
    else if (word != "part")
      problem(on->mark, key + ".on", found(*on), "part, machine");
  }
  Node box = Node::map();
  box.mark = node.mark;
  for (const std::string_view side : {"low", "high"})
    if (const Node* value = node.find(side)) box.set(side, *value);
  body.box = read_box(box, key);
  return body;
}

Node machine_node(const Machine& machine) {
  Node node = Node::map();
  if (!machine.name.empty()) node.set("name", machine.name);
  const Node rest = without_empty(Machine::fields(), &machine);
  for (const Node::Entry& entry : rest.entries()) node.set(entry.key, entry.value);
  if (!(machine.part_frame == Pose{})) node.set("part_frame", pose_node(machine.part_frame));
  Node& joints = node.set("joints", Node::sequence());
  for (const Joint& joint : machine.joints) {
    Node item = Node::map();
    item.set("name", joint.name);
    const Joint plain;
    for (const Field& field : Joint::fields()) {
      const Node value = document::field_value(field, &joint);
      if (value.is_null()) continue;
      if (field.name == "type" || document::to_json(value) != document::to_json(document::field_value(field, &plain)))
        item.set(field.name, value);
      if (field.name == "carries") {
        item.set("axis", triple(joint.axis));
        if (!(joint.origin == Vec3{})) item.set("origin", triple(joint.origin));
        if (joint.low) {
          Node limits = Node::sequence();
          limits.push(*joint.low);
          limits.push(*joint.high);
          item.set("limits", std::move(limits));
        }
      }
    }
    joints.push(std::move(item));
  }
  if (machine.keep_out.empty()) return node;
  Node& bodies = node.set("keep_out", Node::sequence());
  for (const KeepOut& body : machine.keep_out) {
    Node item = Node::map();
    if (!body.name.empty()) item.set("name", body.name);
    item.set("on", body.on == Carries::Part ? "part" : "machine");
    item.set("low", triple(body.box.low));
    item.set("high", triple(body.box.high));
    bodies.push(std::move(item));
  }
  return node;
}

}  // namespace scanmill::plan
