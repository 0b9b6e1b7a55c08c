// SPDX-License-Identifier: Apache-2.0
// The job's `optimise` section, and the limits it shares with growth.
#pragma once
#include <span>

#include "base/fields.hpp"

namespace scanmill::optimise {

struct Params {
  bool smooth = true;   // first pass: the smallest interior angle
  bool feature = true;  // second pass: the variation of normals
  static std::span<const Field> fields();
};

/// What no swap may break (mesh/limits.hpp).
struct Limits {
  double range_mm = 0;       // g1 in mm: no new edge is longer
  double cos_min_angle = 1;  // cosine of g2: no new angle is smaller
};

}  // namespace scanmill::optimise
