// SPDX-License-Identifier: Apache-2.0
// The job's `merge` section.
#pragma once
#include <cstdint>
#include <span>

#include "base/fields.hpp"

namespace scanmill::merge {

struct Params {
  std::int64_t min_patch_triangles = 10;  // smaller pieces join the neighbour with the flattest shared border
  double min_component_share = 0.001;     // of all faces; smaller components are dropped and listed
  static std::span<const Field> fields();
};

}  // namespace scanmill::merge
