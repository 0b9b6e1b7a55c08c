// SPDX-License-Identifier: Apache-2.0
// The mesh in few bytes: places to 16 bits an axis, corners as differences in seven-bit groups, then base64.
#include <algorithm>
#include <cmath>

#include "base/text.hpp"
#include "report/html.hpp"
#include "report/numbers.hpp"
#include "report/sections.hpp"
#include "report/view_script.hpp"

namespace scanmill::report {
namespace {

constexpr double kSteps = 65535;
constexpr std::size_t kPatchKinds = 255;

/// Small numbers of either sign in one byte, larger ones in more: the sign last, seven bits a byte, least first.
void add_difference(std::uint32_t from, std::uint32_t to, std::string& out) {
  const std::int64_t d = static_cast<std::int64_t>(to) - static_cast<std::int64_t>(from);
  auto rest = static_cast<std::uint64_t>(d < 0 ? -2 * d - 1 : 2 * d);
  for (; rest >= 128; rest >>= 7) out += static_cast<char>((rest & 127) | 128);
  out += static_cast<char>(rest);
}

void add_16(double value, std::string& out) {
  const auto whole = static_cast<std::uint32_t>(value);
  out += static_cast<char>(whole & 255);
  out += static_cast<char>(whole >> 8);
}

struct Frame {
  Vec3 low, size;  // of the box; no side is zero
};
Frame frame_of(const SurfaceView& view) {
  Bounds box;
  for (const Vec3& p : view.positions) box.add(p);
  if (box.empty()) return {{}, {1, 1, 1}};
  const Vec3 size = box.size();
  const double least = std::max({size.x, size.y, size.z, 1e-6}) * 1e-6;
  return {box.low, {std::max(size.x, least), std::max(size.y, least), std::max(size.z, least)}};
}

char error_code(double error_mm, double range_mm) {
  if (std::isnan(error_mm)) return 0;
  const double t = error_mm / range_mm;
  return static_cast<char>(t < -1 ? 1 : t > 1 ? 255 : static_cast<int>((t + 1) * 126 + 2.5));
}

/// Places, corners, patches, errors and open edges, in this order; kViewScript reads them so.
std::string packed(const SurfaceView& view) {
  const Frame frame = frame_of(view);
  std::string out;
  out.reserve(view.positions.size() * 7 + view.triangles.size() * 7);
  const auto step = [](double at, double size) { return std::clamp(at / size, 0.0, 1.0) * kSteps + 0.5; };
  for (const Vec3& p : view.positions) {
    const Vec3 d = p - frame.low;
    add_16(step(d.x, frame.size.x), out);
    add_16(step(d.y, frame.size.y), out);
    add_16(step(d.z, frame.size.z), out);
  }
  std::uint32_t last = 0;
  for (const auto& x : view.triangles) {
    add_difference(last, x[0], out);
    add_difference(x[0], x[1], out);
    add_difference(x[1], x[2], out);
    last = x[0];
  }
  const std::size_t kinds = std::clamp<std::size_t>(view.patch_colours.size(), 1, kPatchKinds);
  for (const std::uint32_t patch : view.patch) out += static_cast<char>(patch % kinds);
  const double range_mm = view.error_range_mm > 0 ? view.error_range_mm : 1;
  for (const double error : view.errors) out += error_code(error, range_mm);
  last = 0;
  for (const auto& [a, b] : view.open_edges) {
    add_difference(last, a, out);
    add_difference(a, b, out);
    last = a;
  }
  return out;
}

std::string hex(const SurfaceView::Colour& colour) {
  static constexpr char kDigits[] = "0123456789abcdef";
  std::string text;
  for (const std::uint8_t c : colour) {
    text += kDigits[c >> 4];
    text += kDigits[c & 15];
  }
  return text;
}

std::string hex(const std::vector<SurfaceView::Colour>& colours, std::size_t most) {
  std::string text;
  for (std::size_t n = 0; n < std::min(colours.size(), most); ++n) text += hex(colours[n]);
  return text;
}

std::string words(Vec3 v) { return number_text(v.x) + " " + number_text(v.y) + " " + number_text(v.z); }

void add_legend(const SurfaceView& view, std::string& out) {
  const auto& colours = view.error_colours;
  if (view.errors.empty() || colours.size() != kErrorColours) return;
  const auto swatch = [&](std::size_t code, const std::string& text) {
    out += "<span><i style=\"background:#" + hex(colours[code]) + "\"></i>" + escaped(text) + "</span>";
  };
  const std::string range = figure(view.error_range_mm) + " mm";
  out += "<p class=\"legend\" id=\"view-errors\" hidden=\"hidden\">";
  swatch(1, "below");
  out += "<span>" + escaped("\xe2\x88\x92" + range) + "<i class=\"scale\" style=\"background:linear-gradient(to right";
  for (std::size_t code = 2; code <= 254; code += 21) out += ",#" + hex(colours[code]);
  out += "\"></i>" + escaped("+" + range) + "</span>";
  swatch(255, "above");
  out += "<span>fit error of each vertex\xe2\x80\x99s bin: blue inside, red outside</span></p>\n";
}

void add_tools(const SurfaceView& view, std::string& out) {
  out += "<div class=\"tools\" id=\"view-tools\" hidden=\"hidden\">\n";
  const auto choice = [&](const char* name, const char* text, bool chosen) {
    out += std::string("<label><input type=\"radio\" name=\"view-colours\" value=\"") + name + "\"" +
           (chosen ? " checked=\"checked\"" : "") + "/>" + text + "</label>\n";
  };
  choice("shaded", "shaded", true);
  if (!view.patch.empty()) choice("patches", "patches", false);
  if (!view.errors.empty()) choice("error", "fit error", false);
  if (!view.open_edges.empty())
    out += "<label><input type=\"checkbox\" id=\"view-open\" checked=\"checked\"/>open edges</label>\n";
  for (const char* side : {"iso", "+x", "-x", "+y", "-y", "+z", "-z"})
    out += std::string("<button type=\"button\" value=\"") + side + "\">" + side + "</button>\n";
  out += "</div>\n";
}

}  // namespace

void add_view(const SurfaceView& view, const Picture* picture, std::string& out) {
  const Frame frame = frame_of(view);
  add_heading(out, "view", "3-D view");
  out += "<div class=\"view\" id=\"view-box\" data-vertices=\"" + std::to_string(view.positions.size()) +
         "\" data-triangles=\"" + std::to_string(view.triangles.size()) + "\" data-patches=\"" +
         std::to_string(view.patch.size()) + "\" data-errors=\"" + std::to_string(view.errors.size()) +
         "\" data-open=\"" + std::to_string(view.open_edges.size()) + "\" data-size=\"" + words(frame.size) +
         "\" data-range=\"" + number_text(view.error_range_mm) + "\" data-low=\"" + words(frame.low) +
         "\" data-shades=\"" + hex(view.front) + hex(view.back) + hex(view.open) + "\" data-patch-colours=\"" +
         hex(view.patch_colours, kPatchKinds) + "\" data-error-colours=\"" + hex(view.error_colours, kErrorColours) +
         "\">\n";
  add_tools(view, out);
  if (picture) add_picture(*picture, out);
  out +=
      "<p class=\"quiet\" id=\"view-says\" hidden=\"hidden\"></p>\n<noscript><p class=\"quiet\">The 3-D view needs "
      "JavaScript" +
      std::string(picture ? "; this is the picture instead" : "") + ".</p></noscript>\n";
  add_legend(view, out);
  if (view.cell_mm > 0)
    out += "<p class=\"quiet\">Coarser than the mesh, so that the page stays small: " + grouped(view.triangles.size()) +
           " of " + grouped(view.full_triangles) + " triangles. Of the vertices in one cell of a grid of " +
           escaped(figure(view.cell_mm)) +
           " mm the one nearest to its centre is shown, with the greatest error among them. Files and figures are of "
           "the whole mesh.</p>\n";
  out += "</div>\n";
}

void add_view_script(const SurfaceView& view, std::string& out) {
  out += "<script type=\"application/octet-stream\" id=\"view-data\">" + base64(packed(view)) + "</script>\n<script>" +
         kViewScript + "</script>\n";
}

}  // namespace scanmill::report
