// SPDX-License-Identifier: Apache-2.0
#include "plan/accuracy.hpp"

#include <algorithm>
#include <cmath>

#include "plan/stations.hpp"

namespace scanmill::plan {

std::optional<PoseAccuracy> accuracy_of(const ScanPlan& plan) {
  constexpr double kRadian = 57.29577951308232;
  if (!plan.machine) return {};
  const Machine& machine = *plan.machine;
  PoseAccuracy most;
  for (const State& state : settle(plan)) {
    if (!state.known || state.joints.size() != machine.joints.size()) continue;
    const std::vector<AxisAt> axes = axes_at(machine, state.joints);
    double squares = 0, turned = 0, turn = 0;
    for (std::size_t i = 0; i < axes.size(); ++i) {
      const Joint& joint = machine.joints[i];
      if (joint.type == JointType::Linear) {
        squares += joint.accuracy * joint.accuracy;
        continue;
      }
      const double lever = norm(cross(state.at.sensor.translation - axes[i].origin, axes[i].direction));
      turned += joint.accuracy / kRadian * lever;
      turn += joint.accuracy;
    }
    most.shift_mm = std::max(most.shift_mm, std::sqrt(squares) + turned);
    most.turn_deg = std::max(most.turn_deg, turn);
  }
  if (most.shift_mm == 0 && most.turn_deg == 0) return {};
  return most;
}

}  // namespace scanmill::plan
