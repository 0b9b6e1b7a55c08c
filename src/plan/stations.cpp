// SPDX-License-Identifier: Apache-2.0
#include "plan/stations.hpp"

#include <algorithm>
#include <cmath>

#include "base/text.hpp"
#include "geom/angles.hpp"
#include "plan/solve.hpp"

namespace scanmill::plan {
namespace {

constexpr double kElevationSlack = 1e-6;  // degrees

class Walk {
 public:
  explicit Walk(const ScanPlan& plan) : plan_(plan) {
    if (!plan.machine) return;
    for (const Joint& joint : plan.machine->joints) last_.joints.push_back(joint.home);
    last_.turns.assign(last_.joints.size(), 0);
    last_.counts.assign(last_.joints.size(), 0);
    last_.direction.assign(last_.joints.size(), 1);
  }

  State next(const Station& station) {
    State state;
    if (!plan_.machine || (plan_.machine->joints.empty() && station.given_pose)) {
      state.known = false;
      state.at.sensor = state.at.view = station.given_pose ? *station.given_pose : station.pose;
      if (station.target) state.at.sensor = state.at.view = view_of(*station.target, plan_.sensor.stand_off_mm);
      return state;
    }
    if (station.counts)
      take_counts(station, state);
    else if (station.joints)
      take_joints(*station.joints, state);
    else if (!take_wish(station, state))
      return state;
    state.at = place(*plan_.machine, plan_.mount, state.joints);
    if (station.joints) state.commanded = *station.joints;
    compare(station, state);
    check(station, state);
    last_ = {state.joints, state.turns, state.counts, state.direction};
    return state;
  }

 private:
  struct Last {
    std::vector<double> joints, turns;
    std::vector<std::int64_t> counts;
    std::vector<int> direction;
  };

  void take_counts(const Station& station, State& state) {
    state.joints = station.joints ? *station.joints : last_.joints;
    state.turns = last_.turns;
    state.counts = *station.counts;
    state.direction = last_.direction;
    for (std::size_t i = 0; i < state.counts.size(); ++i) {
      const Joint& joint = plan_.machine->joints[i];
      if (counts_per_turn(joint) == 0) continue;
      if (state.counts[i] != last_.counts[i]) state.direction[i] = state.counts[i] > last_.counts[i] ? 1 : -1;
      state.turns[i] = turns_of(joint, state.counts[i]);
      state.joints[i] = value_of(joint, state.counts[i], state.direction[i]);
    }
  }

  void take_joints(const std::vector<double>& wanted, State& state) {
    state.joints = wanted;
    state.turns.assign(wanted.size(), 0);
    state.counts.assign(wanted.size(), 0);
    state.direction = last_.direction;
    for (std::size_t i = 0; i < wanted.size(); ++i) {
      const Joint& joint = plan_.machine->joints[i];
      const double least = travel_per_count(joint) / 2 + 1e-12;  // less is no move
      if (std::abs(wanted[i] - last_.joints[i]) > least) state.direction[i] = wanted[i] > last_.joints[i] ? 1 : -1;
      if (counts_per_turn(joint) == 0) {
        if (joint.type == JointType::Rotary || joint.lead_mm > 0)
          state.turns[i] = turns_of_value(joint, wanted[i], state.direction[i]);
        continue;
      }
      state.counts[i] = counts_of(joint, wanted[i], state.direction[i]);
      state.turns[i] = turns_of(joint, state.counts[i]);
      state.joints[i] = value_of(joint, state.counts[i], state.direction[i]);
    }
  }

  bool take_wish(const Station& station, State& state) {
    const bool aimed = !station.given_pose && station.target.has_value();
    const Wish wish{
        aimed ? view_of(*station.target, plan_.sensor.stand_off_mm) : station.given_pose.value_or(station.pose),
        !aimed};
    const Solution found = solve(*plan_.machine, plan_.mount, plan_.sensor.stand_off_mm, wish, last_.joints);
    if (found.reach == Reach::Exact || found.reach == Reach::RollFree) {
      if (found.reach == Reach::RollFree)
        note(state, station, Severity::Warning, "roll", "", found.roll_deg, 0,
             "the machine reaches place and direction, not the turn about the viewing axis: " +
                 rounded(found.roll_deg) + " deg are left");
      take_joints(found.joints, state);
      return true;
    }
    state.known = false;
    state.at.sensor = state.at.view = wish.view;
    if (found.reach == Reach::Nowhere) {
      note(state, station, Severity::Error, "unreachable", "", found.miss_mm, 0,
           "unreachable: no setting of the joints brings the sensor there; the nearest misses it by " +
               rounded(found.miss_mm) + " mm and " + rounded(found.miss_deg) + " deg");
      return false;
    }
    for (std::size_t i = 0; i < found.joints.size(); ++i) {
      const Joint& joint = plan_.machine->joints[i];
      if (!joint.low || (found.joints[i] >= *joint.low && found.joints[i] <= *joint.high)) continue;
      const double limit = found.joints[i] < *joint.low ? *joint.low : *joint.high;
      note(state, station, Severity::Error, "unreachable", joint.name, found.joints[i], limit,
           "unreachable: joint " + joint.name + " would have to go to " + rounded(found.joints[i]) + " " +
               unit_of(joint) + ", its limit is " + rounded(limit) + " " + unit_of(joint));
    }
    return false;
  }

  /// What was given besides and does not fit.
  void compare(const Station& station, State& state) const {
    const Machine& machine = *plan_.machine;
    for (std::size_t i = 0; station.counts && station.joints && i < machine.joints.size(); ++i) {
      const Joint& joint = machine.joints[i];
      const double off = state.joints[i] - (*station.joints)[i],
                   allowed = std::max(joint.accuracy, travel_per_count(joint));
      if (std::abs(off) <= allowed) continue;
      note(state, station, Severity::Warning, "counts_differ", joint.name, off, allowed,
           "joint " + joint.name + " was told to go to " + rounded((*station.joints)[i]) + " " + unit_of(joint) +
               " and its counts say " + rounded(state.joints[i]) + ", " + rounded(std::abs(off)) + " " +
               unit_of(joint) + " off; allowed " + rounded(allowed));
    }
    if (!station.given_pose || (!station.counts && !station.joints)) return;
    const PoseGap gap = gap_between(state.at.view, *station.given_pose);
    if (gap.mm <= machine.pose_tolerance_mm && gap.degrees <= machine.pose_tolerance_deg) return;
    const bool by_place = gap.mm > machine.pose_tolerance_mm;
    note(state, station, Severity::Warning, "pose_differs", "", by_place ? gap.mm : gap.degrees,
         by_place ? machine.pose_tolerance_mm : machine.pose_tolerance_deg,
         std::string("the pose given lies ") + rounded(gap.mm) + " mm and " + rounded(gap.degrees) +
             " deg from the one of the " + (station.counts ? "counts" : "joints") + "; allowed " +
             rounded(machine.pose_tolerance_mm) + " mm and " + rounded(machine.pose_tolerance_deg) +
             " deg; the points are placed by the " + (station.counts ? "counts" : "joints"));
  }

  void check(const Station& station, State& state) const {
    const Machine& machine = *plan_.machine;
    for (std::size_t i = 0; i < machine.joints.size(); ++i) {
      const Joint& joint = machine.joints[i];
      if (!joint.low) continue;
      // What was asked for is judged as asked; the nearest count would only blur the number.
      const double value = station.joints && !station.counts ? (*station.joints)[i] : state.joints[i];
      const double slack = travel_per_count(joint) / 2 + 1e-9;
      if (value >= *joint.low - slack && value <= *joint.high + slack) continue;
      const double limit = value < *joint.low ? *joint.low : *joint.high;
      note(state, station, Severity::Error, "limit", joint.name, value, limit,
           "joint " + joint.name + " at " + rounded(value) + " " + unit_of(joint) + " is beyond its limit of " +
               rounded(limit) + " " + unit_of(joint));
    }
    const double elevation = elevation_of(state.at.sensor);
    if (machine.max_elevation_deg && elevation > *machine.max_elevation_deg + kElevationSlack)
      note(state, station, Severity::Error, "elevation", "", elevation, *machine.max_elevation_deg,
           "the sensor looks " + rounded(elevation) + " deg above the horizontal; the limit is " +
               rounded(*machine.max_elevation_deg) + " deg (machine.max_elevation_deg)");
    for (const std::string& body : bodies_met(plan_, state.at))
      note(state, station, Severity::Error, "collision", "", 0, 0, "the head meets " + body);
  }

  static void note(State& state, const Station& station, Severity severity, const char* kind, const std::string& joint,
                   double value, double limit, const std::string& text) {
    state.findings.push_back(
        {severity, kind, station.name, joint, value, limit, "station " + station.name + ": " + text});
  }

  const ScanPlan& plan_;
  Last last_;
};

}  // namespace

const char* unit_of(const Joint& joint) { return joint.type == JointType::Linear ? "mm" : "deg"; }

std::string rounded(double value) {
  const double steps = std::floor(std::abs(value) * 1e4 + 0.5);
  return number_text(value < 0 && steps > 0 ? -steps / 1e4 : steps / 1e4);
}

double elevation_of(const Pose& sensor_in_machine) {
  return 90 - degrees_between(sensor_in_machine.turn({0, 0, 1}), {0, 0, 1});
}

Pose view_of(const Target& target, double stand_off_mm) {
  const double distance = target.stand_off_mm.value_or(stand_off_mm);
  return pose_looking_at(target.point + target.normal * distance, target.point, {0, 0, 1});
}

std::vector<std::string> bodies_met(const ScanPlan& plan, const Placed& at) {
  std::vector<std::string> met;
  if (!plan.mount.body || !plan.machine) return met;
  // Bodies on the deck stand in the frame of the last joint that carries the part.
  const Pose deck = at.part.after(plan.machine->part_frame.inverse());
  for (const KeepOut& body : plan.machine->keep_out)
    if (boxes_meet(at.sensor, *plan.mount.body, body.on == Carries::Part ? deck : Pose{}, body.box))
      met.push_back(body.name.empty() ? "a keep-out box" : body.name);
  if (plan.part && boxes_meet(at.sensor, *plan.mount.body, at.part, *plan.part)) met.push_back("the part");
  return met;
}

std::vector<State> settle(const ScanPlan& plan) {
  std::vector<State> states;
  Walk walk(plan);
  for (const Station& station : plan.stations) states.push_back(walk.next(station));
  return states;
}

void place_stations(ScanPlan& plan) {
  const auto is_given = [](const Station& station) { return station.given_pose && !station.counts && !station.joints; };
  if (std::all_of(plan.stations.begin(), plan.stations.end(), is_given)) {  // nothing to be worked out
    for (Station& station : plan.stations) station.pose = *station.given_pose;
    return;
  }
  const std::vector<State> states = settle(plan);
  for (std::size_t i = 0; i < states.size(); ++i) {
    Station& station = plan.stations[i];
    station.pose = is_given(station) ? *station.given_pose : states[i].at.view;
  }
}

}  // namespace scanmill::plan
