// SPDX-License-Identifier: Apache-2.0
// What a drawing of a section shows and says, the same in every format.
#pragma once
#include <string>
#include <utility>
#include <vector>

#include "mesh/section.hpp"

namespace scanmill {

/// What has to fit into the drawing: lines, points, ends of magnified deviations.
struct DrawnBounds {
  Uv low{1e300, 1e300}, high{-1e300, -1e300};
  bool empty() const { return low.u > high.u; }
  void add(Uv p);
};
DrawnBounds drawn_bounds(const Section& section);

/// Where the magnified deviation of a point ends; its beginning is the foot.
Uv deviation_end(const Section& section, const SectionPoint& point);

/// "1,234 points within 0.5 mm; greatest 0.8 mm, rms 0.051 mm; deviations x 20"
std::string section_figures(const Section& section);
/// "0.80 mm at 12.3 4.5 6.7"
std::string worst_text(const SectionPoint& worst);

}  // namespace scanmill
