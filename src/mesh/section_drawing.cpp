// SPDX-License-Identifier: Apache-2.0
#include "mesh/section_drawing.hpp"

#include <algorithm>
#include <cmath>

#include "base/text.hpp"

namespace scanmill {
namespace {

/// To `step`, without the rest of binary fractions.
std::string rounded(double value, double steps_per_mm) {
  const double whole = std::floor(value * steps_per_mm + 0.5);
  return number_text(whole == 0 ? 0 : whole / steps_per_mm);
}

}  // namespace

void DrawnBounds::add(Uv p) {
  low = {std::min(low.u, p.u), std::min(low.v, p.v)};
  high = {std::max(high.u, p.u), std::max(high.v, p.v)};
}

Uv deviation_end(const Section& section, const SectionPoint& point) {
  const double length = section.magnify * point.signed_mm;
  return {point.foot.u + point.outward.u * length, point.foot.v + point.outward.v * length};
}

DrawnBounds drawn_bounds(const Section& section) {
  DrawnBounds bounds;
  for (const SectionLine& line : section.lines)
    for (const Uv& p : line.points) bounds.add(p);
  for (const SectionPoint& point : section.points) {
    bounds.add(point.at);
    if (point.has_foot) bounds.add(deviation_end(section, point));
  }
  if (section.worst) {
    bounds.add(section.worst->at);
    if (section.worst->has_foot) bounds.add(deviation_end(section, *section.worst));
  }
  // A plane that only touches gives a dot; drawn to fill the sheet it would have a scale of no sense.
  const double least = section.frame.slab_mm > 0 ? section.frame.slab_mm : 1;
  if (!bounds.empty() && bounds.high.u - bounds.low.u < least / 100 && bounds.high.v - bounds.low.v < least / 100) {
    const Uv middle{(bounds.low.u + bounds.high.u) / 2, (bounds.low.v + bounds.high.v) / 2};
    bounds.add({middle.u - least, middle.v});
    bounds.add({middle.u + least, middle.v});
  }
  return bounds;
}

std::string section_figures(const Section& section) {
  if (section.lines.empty() && section.points_in_slab == 0) return "the plane meets neither the mesh nor a point";
  std::string text =
      counted(section.points_in_slab, "point") + " within " + rounded(section.frame.slab_mm / 2, 1e4) + " mm";
  if (section.points_in_slab == 0) return text;
  text += "; greatest " + rounded(section.max_mm, 1e3) + " mm, rms " + rounded(section.rms_mm, 1e3) +
          " mm; deviations x " + number_text(section.magnify);
  if (section.points_at_open_border > 0)
    text += "; " + grouped(section.points_at_open_border) + " beyond open edges apart";
  if (section.points.size() < section.points_in_slab) text += "; " + grouped(section.points.size()) + " drawn";
  return text;
}

std::string worst_text(const SectionPoint& worst) {
  return (worst.signed_mm > 0 ? "+" : "") + rounded(worst.signed_mm, 1e3) + " mm at " + rounded(worst.place.x, 1e2) +
         " " + rounded(worst.place.y, 1e2) + " " + rounded(worst.place.z, 1e2);
}

}  // namespace scanmill
