// SPDX-License-Identifier: Apache-2.0
// What the job asks for under verify.sections.
#pragma once
#include <cstdint>
#include <optional>
#include <string>

#include "geom/vec3.hpp"

namespace scanmill::verify {

/// Planes at right angles to `axis`: one at a position, `count` spread evenly through the mesh, or one through a
/// feature.
struct SectionRule {
  enum class Where : std::int32_t { At, Count, Worst, Loop, Point };
  Vec3 axis{0, 0, 1};  // any length but zero
  Where where = Where::Worst;
  double at_mm = 0;               // At: distance of the plane from the origin of the global frame, along the axis
  std::int64_t count = 1;         // Count: 1 .. 100
  Vec3 point;                     // Point
  std::optional<double> slab_mm;  // thickness of the slab of points; the bin edge when not given
  std::optional<double> magnify;  // of deviations in drawings; chosen by the size of the section when not given
  std::string name;               // of the section; made from its place when empty
  friend bool operator==(const SectionRule&, const SectionRule&) = default;
};

}  // namespace scanmill::verify
