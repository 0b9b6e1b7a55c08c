// SPDX-License-Identifier: Apache-2.0
// `plan propose`: stations for an object from a first mesh or a box.
#pragma once
#include <cstdint>
#include <optional>
#include <string>

#include "pipeline/tools.hpp"

namespace scanmill::pipeline {

struct ProposeChoice {
  std::string object;            // mesh file; or
  std::string box;               // x0,y0,z0,x1,y1,z1
  std::optional<double> bin_mm;  // a fiftieth of the object's largest extent unless given
  double max_angle_deg = 60, coverage = 0.995;
  std::int64_t max_stations = 500;
};

/// `rig` is a plan with machine (may be without joints) and sensor. The plan written has the object's box as `part`.
Result<ToolReport> propose_plan(const std::string& rig, const ProposeChoice& choice, const std::string& output,
                                const Context& context, Progress& progress);

}  // namespace scanmill::pipeline
