// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <charconv>
#include <cmath>
#include <string>

#include "base/text.hpp"
#include "export/section_files.hpp"
#include "mesh/section_drawing.hpp"

namespace scanmill::exporting {
namespace {

// The drawing's own units; the reader scales it.
constexpr double kWidth = 1000, kMargin = 24, kHead = 62, kFoot = 44, kLeastHeight = 160, kMostHeight = 900;

std::string number(double value) {
  char text[48];
  return {text, std::to_chars(text, text + sizeof text, value == 0 ? 0 : value, std::chars_format::fixed, 2).ptr};
}

std::string escaped(const std::string& text) {
  std::string safe;
  for (const char c : text) {
    if (c == '<')
      safe += "&lt;";
    else if (c == '>')
      safe += "&gt;";
    else if (c == '&')
      safe += "&amp;";
    else if (static_cast<unsigned char>(c) < 0x20)
      safe += ' ';
    else
      safe += c;
  }
  return safe;
}

/// Plane to drawing.
struct Panel {
  double top = 0, height = 0, scale = 1;
  double middle_x = 0, middle_y = 0;
  Uv middle;
  double x(Uv p) const { return middle_x + (p.u - middle.u) * scale; }
  double y(Uv p) const { return middle_y - (p.v - middle.v) * scale; }
  std::string place(Uv p) const { return number(x(p)) + " " + number(y(p)); }
};

Panel panel_of(const Section& section, double top) {
  const DrawnBounds bounds = drawn_bounds(section);
  Panel panel;
  panel.top = top;
  panel.height = kLeastHeight;
  const double width = kWidth - 2 * kMargin;
  if (!bounds.empty()) {
    const double du = std::max(bounds.high.u - bounds.low.u, 1e-9), dv = std::max(bounds.high.v - bounds.low.v, 1e-9);
    panel.scale = std::min(width / du, kMostHeight / dv);
    panel.height = std::max(kLeastHeight, dv * panel.scale);
    panel.middle = {(bounds.low.u + bounds.high.u) / 2, (bounds.low.v + bounds.high.v) / 2};
  }
  panel.middle_x = kWidth / 2;
  panel.middle_y = top + kHead + panel.height / 2;
  return panel;
}

std::string text_at(double x, double y, const char* kind, const std::string& words) {
  return "<text x=\"" + number(x) + "\" y=\"" + number(y) + "\" class=\"" + kind + "\">" + escaped(words) + "</text>\n";
}

void add_deviations(const Section& section, const Panel& panel, bool outside, std::string& out) {
  std::string path;
  for (const SectionPoint& point : section.points)
    if (point.has_foot && point.signed_mm != 0 && (point.signed_mm > 0) == outside)
      path += "M" + panel.place(point.foot) + "L" + panel.place(deviation_end(section, point));
  if (!path.empty()) out += "<path class=\"" + std::string(outside ? "out" : "in") + "\" d=\"" + path + "\"/>\n";
}

void add_scale_bar(const Panel& panel, std::string& out) {
  double length = 1e-6;
  for (double power = 1e-6; power < 1e9; power *= 10)
    for (const double digit : {1.0, 2.0, 5.0})
      if (digit * power * panel.scale <= kWidth / 5) length = digit * power;
  const double y = panel.top + kHead + panel.height + 24, x = kMargin;
  out += "<path class=\"bar\" d=\"M" + number(x) + " " + number(y - 4) + "v8m0 -4h" + number(length * panel.scale) +
         "m0 -4v8\"/>\n";
  char shown[32];
  const auto end = std::to_chars(shown, shown + sizeof shown, length, std::chars_format::general, 6).ptr;
  out += text_at(x + length * panel.scale + 8, y + 4, "small", std::string(shown, end) + " mm");
}

void add_panel(const Section& section, const Panel& panel, std::string& out) {
  out += text_at(kMargin, panel.top + 26, "title", section.frame.name);
  out += text_at(kMargin, panel.top + 46, "small", section_figures(section));
  std::string points;
  for (const SectionPoint& point : section.points) points += "M" + panel.place(point.at) + "h0";
  if (!points.empty()) out += "<path class=\"points\" d=\"" + points + "\"/>\n";
  add_deviations(section, panel, true, out);
  add_deviations(section, panel, false, out);
  std::string lines;
  for (const SectionLine& line : section.lines) {
    for (std::size_t n = 0; n < line.points.size(); ++n) lines += (n == 0 ? "M" : "L") + panel.place(line.points[n]);
    if (line.closed) lines += "Z";
  }
  if (!lines.empty()) out += "<path class=\"mesh\" d=\"" + lines + "\"/>\n";
  if (section.worst) {
    const Uv end = section.worst->has_foot ? deviation_end(section, *section.worst) : section.worst->at;
    const double x = panel.x(end), y = panel.y(end);
    out += "<circle class=\"worst\" cx=\"" + number(x) + "\" cy=\"" + number(y) + "\" r=\"9\"/>\n";
    // Towards the middle, where sections are mostly empty.
    const bool left = x > kWidth / 2;
    const double beside = left ? x - 44 : x + 44, below = y + (y > panel.middle_y ? -42 : 50);
    out += "<path class=\"leader\" d=\"M" + number(left ? x - 7 : x + 7) + " " +
           number(y + (y > panel.middle_y ? -6 : 6)) + "L" + number(beside) + " " + number(below - 5) + "\"/>\n";
    out += "<text x=\"" + number(left ? beside - 4 : beside + 4) + "\" y=\"" + number(below) +
           "\" class=\"worst-text\"" + (left ? " text-anchor=\"end\"" : "") + ">" +
           escaped(worst_text(*section.worst)) + "</text>\n";
  }
  add_scale_bar(panel, out);
}

}  // namespace

Result<void> write_sections_svg(std::span<const Section> sections, ByteSink& sink) {
  std::vector<Panel> panels;
  double height = kMargin;
  for (const Section& section : sections) {
    panels.push_back(panel_of(section, height));
    height += kHead + panels.back().height + kFoot;
  }
  std::string out =
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 " + number(kWidth) + " " + number(height) +
      "\" width=\"" + number(kWidth) + "\" height=\"" + number(height) +
      "\" font-family=\"sans-serif\">\n<style>.title{font-size:18px;fill:#22262c}.small{font-size:13px;fill:#6e747c}"
      ".mesh{fill:none;stroke:#22262c;stroke-width:1.6;stroke-linejoin:round}.points{fill:none;stroke:#8a929c;"
      "stroke-width:2.4;stroke-linecap:round}.out{stroke:#c1121f;stroke-width:.7;fill:none}.in{stroke:#1d4ea0;"
      "stroke-width:.7;fill:none}.worst{fill:none;stroke:#e07000;stroke-width:2.4}.leader{stroke:#e07000;stroke-width:"
      "1;fill:none}.worst-text{font-size:15px;"
      "font-weight:bold;fill:#b05800;paint-order:stroke;stroke:#fff;stroke-width:4}.bar{stroke:#22262c;"
      "stroke-width:1.2;fill:none}</style>\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n";
  for (std::size_t n = 0; n < sections.size(); ++n) {
    out += "<g>\n";
    add_panel(sections[n], panels[n], out);
    out += "</g>\n";
    TRY(sink.write(std::string_view(out)));
    out.clear();
  }
  return sink.write(std::string_view(out + "</svg>\n"));
}

}  // namespace scanmill::exporting
