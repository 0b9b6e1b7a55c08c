// SPDX-License-Identifier: Apache-2.0
// The positioner: joints in chain order, what they carry, and how their shafts are counted.
//
// Two chains begin at the machine's frame (z up): joints that carry the sensor, and joints that carry the part. The
// global frame is the part's. A joint's frame lies at `origin` in the frame of the joint before it in its chain and
// moves along (linear, mm) or turns about (rotary, degrees, right-hand rule) `axis`:
//     sensor in machine = J1 J2 ... Jn frame offset      part in machine = K1 ... Km part_frame
//     J = shift(origin) motion(axis, value)               pose of a view  = part^-1 sensor
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/fields.hpp"
#include "geom/pose.hpp"

namespace scanmill::plan {

enum class JointType : std::int32_t { Linear, Rotary };
enum class Carries : std::int32_t { Sensor, Part };

/// Lengths in mm, angles in degrees, speeds in them per second.
struct Joint {
  std::string name;
  JointType type = JointType::Linear;
  Carries carries = Carries::Sensor;
  Vec3 axis{0, 0, 1};  // unit after reading
  Vec3 origin;
  std::optional<double> low, high;  // limits; none: turns without end
  std::optional<double> velocity, acceleration;
  double lead_mm = 0;                      // travel per turn of the screw; linear joints only
  std::int64_t counts_per_rev = 0;         // of the encoder on the motor shaft; 0: none
  std::int64_t steps_per_rev = 0;          // of the stepper motor; 0: none
  double gear = 1;                         // turns of the motor per turn of the screw or of the joint
  double backlash = 0;                     // lost motion between shaft and joint when the direction turns
  double home = 0;                         // value of the joint at count 0, where the path begins
  double accuracy = 0;                     // how well the joint is known to stand where its counter says
  static std::span<const Field> fields();  // all but name, axis, origin, limits
};

struct Box {
  Vec3 low, high;
  friend bool operator==(const Box&, const Box&) = default;
};

/// A body that the head must not meet.
struct KeepOut {
  std::string name;
  Box box;
  Carries on =
      Carries::Part;  // Part: fixed to the deck and given in the frame of its last joint; Sensor: the machine's
};

struct Machine {
  std::string name;
  std::vector<Joint> joints;
  Pose part_frame;  // global frame in the frame of the last joint that carries the part
  std::optional<double> max_elevation_deg;
  double dwell_s = 0;
  double pose_tolerance_mm = 0.05, pose_tolerance_deg = 0.05;
  std::vector<KeepOut> keep_out;
  static std::span<const Field> fields();  // max_elevation_deg, dwell_s, tolerances
  /// Position of a joint, or nothing.
  std::optional<std::size_t> find(std::string_view name) const;
};

/// Where the sensor sits on the last joint that carries it.
struct Mount {
  Pose frame;               // sensor frame in that joint's frame, as designed
  Pose offset;              // what calibration found, in the sensor's own frame
  std::optional<Box> body;  // the head's housing, in the sensor frame
  Pose whole() const { return frame.after(offset); }
};

/// Counts or steps per turn of the motor shaft; 0 when the joint is not counted. An encoder goes before the stepper.
std::int64_t counts_per_turn(const Joint& joint);
/// mm or degrees per turn of the motor shaft.
double travel_per_turn(const Joint& joint);
/// mm or degrees per count: lead / (counts_per_rev gear), or 360 / (steps_per_rev gear); 0 when not counted.
double travel_per_count(const Joint& joint);

/// A joint that came in negative direction stands `backlash` higher than the shaft says (the other flank of the thread
/// carries it); direction is -1 or 1.
double turns_of(const Joint& joint, std::int64_t counts);
double value_of_turns(const Joint& joint, double turns, int direction);
double value_of(const Joint& joint, std::int64_t counts, int direction);
double turns_of_value(const Joint& joint, double value, int direction);
/// The nearest count, halves away from zero; value_of gives a value back within half a count, and counts_of what
/// value_of was given.
std::int64_t counts_of(const Joint& joint, double value, int direction);

/// Both chains at one setting, in the machine's frame, and the pose of the view.
struct Placed {
  Pose sensor, part, view;
};
/// joints  one value per joint of the machine
Placed place(const Machine& machine, const Mount& mount, std::span<const double> joints);

/// Where a joint's axis is at that setting, in the machine's frame.
struct AxisAt {
  Vec3 origin, direction;
};
std::vector<AxisAt> axes_at(const Machine& machine, std::span<const double> joints);

/// Whether two boxes, each in its own frame, overlap (they may touch).
bool boxes_meet(const Pose& a_frame, const Box& a, const Pose& b_frame, const Box& b);

}  // namespace scanmill::plan
