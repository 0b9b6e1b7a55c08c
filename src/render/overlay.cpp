// SPDX-License-Identifier: Apache-2.0
#include "render/overlay.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "render/colours.hpp"
#include "render/strokes.hpp"

namespace scanmill::render {
namespace {

std::string tick_text(double value, double range_mm) {
  return (value > 0 ? "+" : "") + length_text(value, range_mm / 2);
}

}  // namespace

Layout layout_of(int width, int height, bool with_title, double error_range_mm) {
  Layout l;
  l.text = std::clamp(std::min(width, height) / 72.0, 8.0, 60.0);
  const double margin = 1.6 * l.text;
  l.title = {margin, margin, width - 2 * margin, with_title ? 2.2 * l.text : 0};
  const double strip = 5.6 * l.text;
  l.strip = {margin, height - margin / 2 - strip, width - 2 * margin, strip};
  const double numbers = text_width(tick_text(-error_range_mm, error_range_mm), l.text);
  const double legend = error_range_mm > 0 ? std::max(9.0 * l.text, 4.8 * l.text + numbers) : 0;
  const double top = l.title.top + l.title.height;
  l.part = {margin, top, width - 2 * margin - legend, l.strip.top - 1.5 * l.text - top};
  l.legend = {width - margin - legend, top, legend, l.part.height};
  return l;
}

std::string length_text(double value, double step) {
  char digits[64];
  if (!(std::abs(value) < 1e10))
    return {digits, std::to_chars(digits, digits + sizeof digits, value, std::chars_format::scientific, 0).ptr};
  int decimals = 0;  // the least that write the step exactly
  for (double scaled = step; decimals < 12 && std::abs(scaled - std::floor(scaled + 0.5)) > 1e-6 * scaled; scaled *= 10)
    ++decimals;
  const auto end =
      std::to_chars(digits, digits + sizeof digits, std::abs(value), std::chars_format::fixed, decimals).ptr;
  std::string text(digits, end);
  for (std::size_t at = std::min(text.find('.'), text.size()); at > 3;) text.insert(at -= 3, ",");
  return value < 0 ? "-" + text : text;
}

void draw_title(Image& image, const Layout& layout, std::string_view title) {
  const double size = layout.text * 1.15;
  draw_text(image, layout.title.left, layout.title.top + size, text_within(title, size, layout.title.width), size,
            kInk);
}

void draw_scale_bar(Image& image, const Layout& layout, double px_per_mm) {
  const double t = layout.text, length = rounded_down_125(layout.strip.width * 0.24 / px_per_mm);
  const double x0 = layout.strip.left + 8.5 * t, x1 = x0 + length * px_per_mm;
  const double y = layout.strip.top + layout.strip.height - 1.6 * t, half = 0.45 * t;
  if (!(x1 - x0 > 1) || x1 > layout.strip.left + layout.strip.width) return;
  const std::array<Segment, 3> bar{{{x0, y, x1, y}, {x0, y - half, x0, y + half}, {x1, y - half, x1, y + half}}};
  draw_strokes(image, bar, std::max(1.6, t / 6), kInk);
  draw_text(image, x0, y - 1.1 * t, length_text(length, length) + " mm", t, kInk);
}

void draw_axes(Image& image, const Layout& layout, const Axes& axes) {
  struct Arm {
    const char* name;
    Vec3 direction;
    Rgb colour;
  };
  std::array<Arm, 3> arms{
      {{"X", {1, 0, 0}, {190, 40, 40}}, {"Y", {0, 1, 0}, {20, 120, 60}}, {"Z", {0, 0, 1}, {30, 80, 190}}}};
  // Those that point away first, so that the near ones lie over them.
  std::stable_sort(arms.begin(), arms.end(), [&](const Arm& a, const Arm& b) {
    return dot(a.direction, axes.toward) < dot(b.direction, axes.toward);
  });
  const double t = layout.text, arm = 2.0 * t, pen = std::max(1.6, t / 5.5);
  const double x = layout.strip.left + 3.1 * t, y = layout.strip.top + layout.strip.height - 2.9 * t;
  for (const Arm& a : arms) {
    const double dx = dot(a.direction, axes.right), dy = -dot(a.direction, axes.up);
    const Segment line{x, y, x + dx * arm, y + dy * arm};
    const double flat = std::sqrt(dx * dx + dy * dy);
    if (flat < 0.1) {  // along the view: a dot for "to you", a ring for "away from you"; the name stands aside
      draw_strokes(image, std::array<Segment, 1>{{{x, y, x, y}}}, 0.9 * t, a.colour);
      if (dot(a.direction, axes.toward) < 0)
        draw_strokes(image, std::array<Segment, 1>{{{x, y, x, y}}}, 0.9 * t - 1.3 * pen, kPaper);
      double side_x = 0, side_y = 0;  // opposite to the other two
      for (const Arm& o : arms) {
        side_x -= dot(o.direction, axes.right);
        side_y += dot(o.direction, axes.up);
      }
      draw_text(image, x + side_x * 1.0 * t, y + side_y * 1.0 * t + t / 2, a.name, t, a.colour, Align::Middle);
      continue;
    }
    draw_strokes(image, std::array<Segment, 1>{line}, pen, a.colour);
    draw_text(image, x + dx * arm + dx / flat * 0.85 * t, y + dy * arm + dy / flat * 0.95 * t + t / 2, a.name, t,
              a.colour, Align::Middle);
  }
}

void draw_caption(Image& image, const Layout& layout, const std::vector<std::string>& lines) {
  const double t = layout.text * 0.92;
  double y =
      layout.strip.top + layout.strip.height - 1.2 * layout.text - static_cast<double>(lines.size() - 1) * 1.9 * t;
  for (const std::string& line : lines) {
    draw_text(image, layout.strip.left + layout.strip.width, y, text_within(line, t, layout.strip.width * 0.5), t,
              kFaintInk, Align::Right);
    y += 1.9 * t;
  }
}

void draw_error_scale(Image& image, const Layout& layout, double range_mm) {
  const double t = layout.text, bar = 1.7 * t, cap = 1.2 * t;
  const double height = std::min(layout.legend.height - 6 * t, 34 * t);
  const double x0 = layout.legend.left + 1.5 * t, x1 = x0 + bar;
  const double y0 = layout.legend.top + (layout.legend.height - height) / 2 + 1.5 * t, y1 = y0 + height;
  const ErrorScale scale;
  for (double y = y0; y < y1; y += 1) {
    const double u = (y + 0.5 - y0) / height;
    fill_box(image, x0, y, x1, y + 1, scale.at(std::clamp(1 - 2 * u, -1.0, 1.0)));
  }
  fill_box(image, x0, y0 - cap, x1, y0, ErrorScale::kAbove);
  fill_box(image, x0, y1, x1, y1 + cap, ErrorScale::kBelow);
  const double pen = std::max(1.0, t / 9);
  const std::array<Segment, 4> frame{{{x0, y0 - cap, x1, y0 - cap},
                                      {x1, y0 - cap, x1, y1 + cap},
                                      {x1, y1 + cap, x0, y1 + cap},
                                      {x0, y1 + cap, x0, y0 - cap}}};
  draw_strokes(image, frame, pen, kInk);
  for (int tick = -4; tick <= 4; ++tick) {
    const double y = y0 + height * (4 - tick) / 8;
    const bool named = tick % 2 == 0;
    draw_strokes(image, std::array<Segment, 1>{{{x1, y, x1 + (named ? 0.6 : 0.3) * t, y}}}, pen, kInk);
    if (!named) continue;
    const double value = range_mm * tick / 4;
    draw_text(image, x1 + 1.1 * t, y + t / 2, tick_text(value, range_mm), t, kInk);
  }
  draw_text(image, x0, y0 - cap - 2.4 * t, "fit error", t, kInk);
  draw_text(image, x0, y0 - cap - 0.8 * t, "mm", t, kInk);
}

void draw_message(Image& image, const Layout& layout, const std::vector<std::string>& lines) {
  double y = layout.part.top + layout.part.height / 2 - static_cast<double>(lines.size() - 1) * 1.2 * layout.text;
  for (const std::string& line : lines) {
    const double size = layout.text * 1.2;
    draw_text(image, layout.part.left + layout.part.width / 2, y, text_within(line, size, layout.part.width), size,
              kInk, Align::Middle);
    y += 2.4 * layout.text;
  }
}

}  // namespace scanmill::render
