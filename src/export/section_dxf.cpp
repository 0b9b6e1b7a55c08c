// SPDX-License-Identifier: Apache-2.0
#include <string>
#include <vector>

#include "base/text.hpp"
#include "export/dxf.hpp"
#include "export/section_files.hpp"
#include "mesh/section_drawing.hpp"

namespace scanmill::exporting {
namespace {

constexpr int kMeshColour = 7, kPointColour = 8, kDeviationColour = 1, kWorstColour = 30;

std::string layer_of(std::size_t section, const char* what) {
  return "SECTION_" + std::to_string(section + 1) + "_" + what;
}

Result<void> write_worst(const Section& section, std::size_t number, DxfWriter& out) {
  const SectionPoint& worst = *section.worst;
  const DrawnBounds bounds = drawn_bounds(section);
  const double size = 0.01 * std::max(bounds.high.u - bounds.low.u, bounds.high.v - bounds.low.v);
  const std::string layer = layer_of(number, "WORST");
  for (const Vec3 arm : {section.frame.right * size, section.frame.up * size})
    TRY(out.line(layer, worst.place - arm, worst.place + arm));
  return out.text(layer, worst.place + section.frame.right * (2 * size), 2 * size, worst_text(worst));
}

}  // namespace

Result<void> write_sections_dxf(std::span<const Section> sections, ByteSink& sink) {
  std::vector<DxfLayer> layers;
  std::vector<std::string> comments{"scanmill sections, units mm"};
  Bounds bounds;
  for (std::size_t n = 0; n < sections.size(); ++n) {
    const Section& section = sections[n];
    comments.push_back("SECTION_" + std::to_string(n + 1) + ": " + section.frame.name + ": " +
                       section_figures(section));
    layers.push_back({layer_of(n, "MESH"), kMeshColour});
    layers.push_back({layer_of(n, "POINTS"), kPointColour});
    layers.push_back({layer_of(n, "DEVIATION"), kDeviationColour});
    layers.push_back({layer_of(n, "WORST"), kWorstColour});
    for (const SectionLine& line : section.lines)
      for (const Uv& p : line.points) bounds.add(section.frame.place(p));
    for (const SectionPoint& point : section.points) bounds.add(point.place);
  }
  DxfWriter out(sink);
  TRY(out.begin(bounds, layers, comments));
  std::vector<Vec3> places;
  for (std::size_t n = 0; n < sections.size(); ++n) {
    const Section& section = sections[n];
    for (const SectionLine& line : section.lines) {
      places.clear();
      for (const Uv& p : line.points) places.push_back(section.frame.place(p));
      TRY(out.polyline(layer_of(n, "MESH"), places, line.closed));
    }
    for (const SectionPoint& point : section.points) {
      TRY(out.point(layer_of(n, "POINTS"), point.place));
      if (!point.has_foot) continue;
      TRY(out.line(layer_of(n, "DEVIATION"), section.frame.place(point.foot),
                   section.frame.place(deviation_end(section, point))));
    }
    if (section.worst) TRY(write_worst(section, n, out));
  }
  return out.end();
}

}  // namespace scanmill::exporting
