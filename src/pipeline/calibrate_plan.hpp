// SPDX-License-Identifier: Apache-2.0
// Calibration from archived views of a sphere or a plane.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "pipeline/tools.hpp"

namespace scanmill::pipeline {

struct CalibrateChoice {
  std::vector<std::string> plans;  // one per night, with their views; what changes from the first on is drift
  std::string target;              // sphere or plane
  std::optional<double> radius_mm;
  std::vector<std::string> axes;  // rotary joints whose place and zero are looked for as well
};

/// Mount offset (and axes) of every plan, what is left, drift against the first; the last plan with what was found to
/// `output` unless that is empty.
/// errors  BadUsage for a target or joint that does not exist; those of plans, views and plan::calibrate
Result<ToolReport> calibrate_plans(const CalibrateChoice& choice, const std::string& output, const Context& context,
                                   Progress& progress);

}  // namespace scanmill::pipeline
