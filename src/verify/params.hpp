// SPDX-License-Identifier: Apache-2.0
// The job's `verify` section.
#pragma once
#include <optional>
#include <span>
#include <vector>

#include "base/fields.hpp"
#include "verify/section_rule.hpp"

namespace scanmill::verify {

/// The paper's sensor (section 3.1): 25.4 to 50.8 um.
inline constexpr double kPaperAccuracy = 0.0508;

/// Gates: a mesh beyond one is marked rejected and the run ends with exit code 4. None by default.
struct Params {
  std::optional<double> max_error_mm;  // greatest distance of any input point from the mesh
  std::optional<double> rms_mm;        // root of the mean square over all input points
  std::vector<SectionRule> sections;   // planes to draw; not in fields()
  static std::span<const Field> fields();
};

}  // namespace scanmill::verify
