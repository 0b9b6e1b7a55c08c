// SPDX-License-Identifier: Apache-2.0
// The order in which a machine visits places.
#pragma once
#include <vector>

#include "base/context.hpp"
#include "plan/plan.hpp"

namespace scanmill::plan {

struct Stop {
  std::vector<double> joints;
  bool via = false;  // passed only, so that the head meets nothing
};

/// All places, from home, each once: nearest neighbour, then pieces reversed while that shortens the way (2-opt). A
/// move costs its time (without velocities its way); one on which the head meets a body costs what going round it
/// costs: back along one linear joint to an end of its range, across, and forth again. Where even that meets a body the
/// straight move stays, for the replay to report. cost  O(n^2) moves looked at
std::vector<Stop> shortest_way(const ScanPlan& rig, const std::vector<std::vector<double>>& places,
                               const Context& context);

}  // namespace scanmill::plan
