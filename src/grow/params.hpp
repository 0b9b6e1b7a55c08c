// SPDX-License-Identifier: Apache-2.0
// The job's `seeds` section.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "base/fields.hpp"
#include "geom/vec3.hpp"

namespace scanmill::grow {

/// `seeds: auto` leaves `points` empty; a list of points is also the shorthand `seeds: [[x, y, z], ...]`.
struct SeedParams {
  std::vector<Vec3> points;                // given seeds, global frame, mm, in order
  double spacing_bins = 30;                // least distance between automatic seeds
  bool cover = true;                       // false: keep only what the given seeds reach
  static std::span<const Field> fields();  // spacing_bins and cover; points are read by hand
};

}  // namespace scanmill::grow
