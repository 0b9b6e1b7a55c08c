// SPDX-License-Identifier: Apache-2.0
// The job's `refine` section.
#pragma once
#include <cstdint>
#include <optional>
#include <span>

#include "base/fields.hpp"

namespace scanmill::refine {

struct Params {
  bool poses = false;                  // off: views stay where the machine says they are
  std::optional<double> max_shift_mm;  // how far the sensor may have stood from there; from the plan when empty
  std::optional<double> max_turn_deg;  // how much it may have been turned
  std::optional<double> patch_mm;      // edge of the pieces that views are compared by; from the points when empty
  bool datum = false;                  // bodies fixed to the deck stand where the plan says
  std::int64_t rounds = 40;
  static std::span<const Field> fields();
};

}  // namespace scanmill::refine
