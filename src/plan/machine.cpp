// SPDX-License-Identifier: Apache-2.0
#include "plan/machine.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace scanmill::plan {
namespace {

constexpr std::string_view kTypes[] = {"linear", "rotary"};
constexpr std::string_view kCarries[] = {"sensor", "part"};

Pose motion_of(const Joint& joint, double value) {
  if (joint.type == JointType::Linear) return pose_shifted(joint.origin + joint.axis * value);
  Pose pose = pose_turned(joint.axis, value);
  pose.translation = joint.origin;
  return pose;
}

}  // namespace

std::span<const Field> Joint::fields() {
  static const Field kTable[] = {
      field<Joint, &Joint::type>("type", "", "linear: moves along its axis, mm; rotary: turns about it, degrees.", {},
                                 kTypes),
      field<Joint, &Joint::carries>("carries", "", "What the joint moves: the sensor's head, or the part on its deck.",
                                    {}, kCarries),
      field<Joint, &Joint::velocity>("velocity", "", "Highest speed, mm or degrees per second.", {0, 1e6, true}),
      field<Joint, &Joint::acceleration>("acceleration", "", "Acceleration and braking, mm or degrees per second^2.",
                                         {0, 1e9, true}),
      field<Joint, &Joint::lead_mm>("lead_mm", "", "Travel per turn of the screw; linear joints only.", {0, 1e5}),
      field<Joint, &Joint::counts_per_rev>("counts_per_rev", "", "Encoder counts per turn of the motor shaft.",
                                           {0, 1e9}),
      field<Joint, &Joint::steps_per_rev>("steps_per_rev", "", "Steps per turn of the stepper motor.", {0, 1e9}),
      field<Joint, &Joint::gear>("gear", "", "Turns of the motor per turn of the screw or joint.", {1e-6, 1e6}),
      field<Joint, &Joint::backlash>("backlash", "", "Lost motion when the direction turns, mm or degrees.", {0, 1e3}),
      field<Joint, &Joint::home>("home", "", "Value of the joint at count 0, where the path begins.", {-1e6, 1e6}),
      field<Joint, &Joint::accuracy>("accuracy", "", "Stated accuracy of the joint, mm or degrees.", {0, 1e3}),
  };
  return kTable;
}

std::span<const Field> Machine::fields() {
  static const Field kTable[] = {
      field<Machine, &Machine::max_elevation_deg>(
          "max_elevation_deg", "", "How far above the horizontal the sensor may look; 0: never above it.", {-90, 90}),
      field<Machine, &Machine::dwell_s>("dwell_s", "", "Time that a view takes once the machine stands.", {0, 1e6}),
      field<Machine, &Machine::pose_tolerance_mm>(
          "pose_tolerance_mm", "", "A given pose farther from the one of the counts is reported.", {0, 1e6}),
      field<Machine, &Machine::pose_tolerance_deg>("pose_tolerance_deg", "", "The same for the angle between the two.",
                                                   {0, 180}),
  };
  return kTable;
}

std::optional<std::size_t> Machine::find(std::string_view wanted) const {
  const auto at = std::find_if(joints.begin(), joints.end(), [&](const Joint& joint) { return joint.name == wanted; });
  if (at == joints.end()) return std::nullopt;
  return static_cast<std::size_t>(at - joints.begin());
}

std::int64_t counts_per_turn(const Joint& joint) {
  return joint.counts_per_rev > 0 ? joint.counts_per_rev : joint.steps_per_rev;
}

double travel_per_turn(const Joint& joint) {
  return (joint.type == JointType::Linear ? joint.lead_mm : 360.0) / joint.gear;
}

double travel_per_count(const Joint& joint) {
  const std::int64_t per_turn = counts_per_turn(joint);
  return per_turn > 0 ? travel_per_turn(joint) / static_cast<double>(per_turn) : 0;
}

double turns_of(const Joint& joint, std::int64_t counts) {
  return static_cast<double>(counts) / static_cast<double>(counts_per_turn(joint));
}

double value_of_turns(const Joint& joint, double turns, int direction) {
  return joint.home + turns * travel_per_turn(joint) + (direction < 0 ? joint.backlash : 0);
}

double value_of(const Joint& joint, std::int64_t counts, int direction) {
  return value_of_turns(joint, turns_of(joint, counts), direction);
}

double turns_of_value(const Joint& joint, double value, int direction) {
  return (value - joint.home - (direction < 0 ? joint.backlash : 0)) / travel_per_turn(joint);
}

std::int64_t counts_of(const Joint& joint, double value, int direction) {
  // Beyond 2^53 counts are no longer whole in double; no machine gets there.
  const double counts = std::clamp(
      turns_of_value(joint, value, direction) * static_cast<double>(counts_per_turn(joint)), -0x1p53, 0x1p53);
  return static_cast<std::int64_t>(counts < 0 ? -std::floor(0.5 - counts) : std::floor(counts + 0.5));
}

Placed place(const Machine& machine, const Mount& mount, std::span<const double> joints) {
  Placed at;
  for (std::size_t i = 0; i < machine.joints.size(); ++i) {
    Pose& chain = machine.joints[i].carries == Carries::Sensor ? at.sensor : at.part;
    chain = chain.after(motion_of(machine.joints[i], joints[i]));
  }
  at.sensor = at.sensor.after(mount.whole());
  at.part = at.part.after(machine.part_frame);
  at.view = at.part.inverse().after(at.sensor);
  return at;
}

std::vector<AxisAt> axes_at(const Machine& machine, std::span<const double> joints) {
  std::vector<AxisAt> axes;
  Pose sensor, part;
  for (std::size_t i = 0; i < machine.joints.size(); ++i) {
    const Joint& joint = machine.joints[i];
    Pose& chain = joint.carries == Carries::Sensor ? sensor : part;
    chain = chain.after(motion_of(joint, joints[i]));
    axes.push_back({chain.translation, chain.turn(joint.axis)});
  }
  return axes;
}

bool boxes_meet(const Pose& a_frame, const Box& a, const Pose& b_frame, const Box& b) {
  const auto half = [](const Box& box) { return (box.high - box.low) * 0.5; };
  const auto sides = [](const Pose& pose) {
    const auto& r = pose.rotation;
    return std::array<Vec3, 3>{Vec3{r[0], r[3], r[6]}, Vec3{r[1], r[4], r[7]}, Vec3{r[2], r[5], r[8]}};
  };
  const std::array<Vec3, 3> u = sides(a_frame), v = sides(b_frame);
  const Vec3 ha = half(a), hb = half(b);
  const Vec3 between = b_frame.apply(b.low + hb) - a_frame.apply(a.low + ha);
  const auto reach = [](const std::array<Vec3, 3>& side, Vec3 h, Vec3 axis) {
    return h.x * std::abs(dot(side[0], axis)) + h.y * std::abs(dot(side[1], axis)) + h.z * std::abs(dot(side[2], axis));
  };
  // Two convex bodies are apart when their shadows on one of these axes are (Gottschalk et al. 1996).
  const auto apart_on = [&](Vec3 axis) {
    return norm2(axis) > 1e-12 && std::abs(dot(between, axis)) > reach(u, ha, axis) + reach(v, hb, axis);
  };
  for (std::size_t i = 0; i < 3; ++i) {
    if (apart_on(u[i]) || apart_on(v[i])) return false;
    for (std::size_t j = 0; j < 3; ++j)
      if (apart_on(cross(u[i], v[j]))) return false;
  }
  return true;
}

}  // namespace scanmill::plan
