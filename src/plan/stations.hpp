// SPDX-License-Identifier: Apache-2.0
// Where the machine stands at every station, worked out from whole counts, and what is wrong there.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "plan/plan.hpp"

namespace scanmill::plan {

enum class Severity { Warning, Error };

/// What stands in the way, or what is worth a look.
struct Finding {
  Severity severity = Severity::Error;
  std::string kind;     // limit, unreachable, elevation, collision, roll, pose_differs, counts_differ; replay adds
                        // missing, changed, unreadable, depth, field
  std::string station;  // name
  std::string joint;    // empty where no joint is at fault
  double value = 0, limit = 0;
  std::string text;  // a sentence that begins with the station
};

struct State {
  bool known = true;           // false: no joints are known (free poses without a machine, or unreachable)
  std::vector<double> joints;  // from the counts where a joint is counted
  std::vector<double> turns;   // of the motor shaft, from home
  std::vector<std::int64_t> counts;
  std::vector<int> direction;     // -1 or 1: how each joint came there
  std::vector<double> commanded;  // empty when the plan gives none
  Placed at;  // sensor and part in the machine's frame; without a machine the part's is the identity
  std::vector<Finding> findings;
};

/// The machine begins at home, came there in positive direction, and visits the stations in order; the direction of the
/// last move of each joint decides about backlash.
std::vector<State> settle(const ScanPlan& plan);

/// Sets the pose of every station: of the counts, else the joints (rounded to counts), else as given, else looking at
/// the target.
void place_stations(ScanPlan& plan);

/// Pose looking at a target along its normal, level with the z axis.
Pose view_of(const Target& target, double stand_off_mm);

/// Angle of the viewing direction above the horizontal plane of the machine, degrees.
double elevation_of(const Pose& sensor_in_machine);

/// "the part" and the like, for every body that the head meets at this setting.
std::vector<std::string> bodies_met(const ScanPlan& plan, const Placed& at);

/// mm or deg.
const char* unit_of(const Joint& joint);
/// To a ten-thousandth, for messages.
std::string rounded(double value);

}  // namespace scanmill::plan
