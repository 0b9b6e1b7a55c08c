// SPDX-License-Identifier: Apache-2.0
// How well a machine knows where it put its sensor.
#pragma once
#include <optional>

#include "plan/plan.hpp"

namespace scanmill::plan {

/// Of the sensor's reference point and of its direction, in the global frame.
struct PoseAccuracy {
  double shift_mm = 0, turn_deg = 0;
};

/// From the accuracies of the joints, at the station where they reach farthest: linear joints as root of squares,
/// rotary ones by the distance of their axis from the sensor's reference point. Nothing when the plan has no machine,
/// its joints are known at no station, or none states an accuracy.
std::optional<PoseAccuracy> accuracy_of(const ScanPlan& plan);

}  // namespace scanmill::plan
