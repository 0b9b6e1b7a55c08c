// SPDX-License-Identifier: Apache-2.0
#include "render/section.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "base/text.hpp"
#include "mesh/section_drawing.hpp"
#include "render/camera.hpp"
#include "render/colours.hpp"
#include "render/overlay.hpp"
#include "render/strokes.hpp"

namespace scanmill::render {
namespace {

constexpr Rgb kSlabPoint{138, 146, 156}, kOutside{193, 18, 31}, kInside{29, 78, 160}, kWorst{224, 112, 0};

/// Plane to pixels.
struct Window {
  double left = 0, top = 0, width = 0, height = 0, scale = 1;
  Uv middle;
  double x(Uv p) const { return left + width / 2 + (p.u - middle.u) * scale; }
  double y(Uv p) const { return top + height / 2 - (p.v - middle.v) * scale; }
  Segment between(Uv a, Uv b) const { return {x(a), y(a), x(b), y(b)}; }
};

Window window_of(const Section& section, double width, double text, double lines) {
  const DrawnBounds bounds = drawn_bounds(section);
  Window w;
  const double margin = 1.6 * text;
  w.left = margin;
  w.top = (4.5 + 1.7 * lines) * text;
  w.width = width - 2 * margin;
  w.height = width / 4 - 10.5 * text;
  if (bounds.empty()) return w;
  const double du = std::max(bounds.high.u - bounds.low.u, 1e-9), dv = std::max(bounds.high.v - bounds.low.v, 1e-9);
  w.scale = std::min(w.width / du, (width - 11 * text) / dv);
  w.height = std::max(w.height, dv * w.scale);
  w.middle = {(bounds.low.u + bounds.high.u) / 2, (bounds.low.v + bounds.high.v) / 2};
  return w;
}

void draw_deviations(const Section& section, const Window& w, double pen, Image& image) {
  std::vector<Segment> out, in;
  for (const SectionPoint& point : section.points)
    if (point.has_foot && point.signed_mm != 0)
      (point.signed_mm > 0 ? out : in).push_back(w.between(point.foot, deviation_end(section, point)));
  draw_strokes(image, out, pen, kOutside);
  draw_strokes(image, in, pen, kInside);
}

void draw_lines(const Section& section, const Window& w, double pen, Image& image) {
  std::vector<Segment> segments;
  for (const SectionLine& line : section.lines) {
    for (std::size_t n = 0; n + 1 < line.points.size(); ++n)
      segments.push_back(w.between(line.points[n], line.points[n + 1]));
    if (line.closed && line.points.size() > 1) segments.push_back(w.between(line.points.back(), line.points.front()));
  }
  draw_strokes(image, segments, pen, kInk);
}

void draw_ring(double x, double y, double radius, double pen, Image& image) {
  // A circle as 32 chords from products of one small turn: no library functions.
  constexpr double kCos = 0.98078528040323044913, kSin = 0.19509032201612826785;  // of 11.25 degrees
  std::array<Segment, 32> ring;
  double dx = radius, dy = 0;
  for (Segment& chord : ring) {
    const double nx = dx * kCos - dy * kSin, ny = dx * kSin + dy * kCos;
    chord = {x + dx, y + dy, x + nx, y + ny};
    dx = nx;
    dy = ny;
  }
  draw_strokes(image, ring, pen, kWorst);
}

struct Label {
  double left = 0, base = 0, leader = 0;  // of the words; where the leader ends
  Box box;                                // that they cover
};

std::uint64_t drawn_pixels(const Image& image, const Box& box) {
  const int right = std::min(image.width, static_cast<int>(box.left + box.width) + 1);
  const int bottom = std::min(image.height, static_cast<int>(box.top + box.height) + 1);
  std::uint64_t count = 0;
  for (int row = std::max(0, static_cast<int>(box.top)); row < bottom; ++row)
    for (int column = std::max(0, static_cast<int>(box.left)); column < right; ++column)
      count += !(image.pixel(column, row) == kPaper);
  return count;
}

/// Near the ring, where it hides least of what is drawn; first towards the middle, where sections are mostly empty.
Label place_label(double x, double y, double width, double text, const Window& w, const Image& image) {
  const double middle_x = w.left + w.width / 2, middle_y = w.top + w.height / 2;
  Label best;
  std::uint64_t least = ~std::uint64_t{0};
  for (const double away : {7.5, 4.0, 2.0, 11.0, 15.0, 20.0, 26.0})
    for (const int side : {1, -1})
      for (const int half : {1, -1}) {
        const bool to_left = (x > middle_x) == (side > 0);
        const bool upward = (y > middle_y) == (half > 0);
        Label label;
        label.left = std::clamp(to_left ? x - 8 * text - width : x + 8 * text, text, image.width - text - width);
        label.base = std::clamp(y + (upward ? -away : away) * text, w.top + 1.2 * text, w.top + w.height);
        label.leader = to_left ? label.left + width : label.left;
        label.box = {label.left - 0.3 * text, label.base - 1.4 * text, width + 0.6 * text, 1.85 * text};
        const std::uint64_t hidden = drawn_pixels(image, label.box);
        if (hidden >= least) continue;
        least = hidden;
        best = label;
      }
  return best;
}

void draw_worst(const Section& section, const Window& w, double text, Image& image) {
  const SectionPoint& worst = *section.worst;
  const Uv end = worst.has_foot ? deviation_end(section, worst) : worst.at;
  const double x = w.x(end), y = w.y(end);
  if (worst.has_foot) {
    const Segment whisker = w.between(worst.foot, end);
    draw_strokes(image, {&whisker, 1}, std::max(1.4, text / 6), kWorst);
  }
  draw_ring(x, y, 0.9 * text, std::max(1.6, text / 5), image);
  const std::string words = worst_text(worst);
  const double width = text_width(words, text * 1.1);
  const Label label = place_label(x, y, width, text, w, image);
  const double dx = label.leader - x, dy = label.base - text / 2 - y, length = std::sqrt(dx * dx + dy * dy);
  if (length > 1.2 * text) {
    const double from = 0.9 * text / length;
    const Segment leader{x + dx * from, y + dy * from, x + dx, y + dy};
    draw_strokes(image, {&leader, 1}, std::max(1.0, text / 9), kWorst);
  }
  const Box& box = label.box;
  fill_box(image, box.left, box.top, box.left + box.width, box.top + box.height, kPaper);
  draw_text(image, label.left, label.base, words, text * 1.1, kWorst);
}

void draw_bar(const Window& w, double text, Image& image) {
  const double length = rounded_down_125(w.width / 5 / w.scale), pixels = length * w.scale;
  const double x = w.left, y = image.height - 1.8 * text, half = 0.45 * text;
  const std::array<Segment, 3> bar{
      {{x, y, x + pixels, y}, {x, y - half, x, y + half}, {x + pixels, y - half, x + pixels, y + half}}};
  draw_strokes(image, bar, std::max(1.4, text / 7), kInk);
  draw_text(image, x + pixels + text, y + text / 2, length_text(length, length) + " mm", text, kInk);
}

/// "+x", or a direction as three numbers.
std::string direction_text(Vec3 d) {
  const double parts[] = {d.x, d.y, d.z};
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (std::abs(parts[axis]) > 0.9999)
      return std::string(parts[axis] > 0 ? "+" : "-") + static_cast<char>('x' + static_cast<int>(axis));
  const auto two_digits = [](double value) { return number_text(std::floor(value * 100 + 0.5) / 100 + 0.0); };
  return "(" + two_digits(d.x) + " " + two_digits(d.y) + " " + two_digits(d.z) + ")";
}

void draw_directions(const SectionFrame& frame, double text, Image& image) {
  const std::string words = "right " + direction_text(frame.right) + ", up " + direction_text(frame.up);
  draw_text(image, image.width - 1.6 * text - text_width(words, text), image.height - 1.3 * text, words, text,
            kFaintInk);
}

/// Parts between semicolons, as many to a line as there is room for.
std::vector<std::string> wrapped(const std::string& words, double size, double room) {
  std::vector<std::string> lines;
  for (std::size_t at = 0; at < words.size();) {
    const std::size_t end = std::min(words.find("; ", at), words.size());
    const std::string part = words.substr(at, end - at);
    if (lines.empty() || text_width(lines.back() + "; " + part, size) > room)
      lines.push_back(part);
    else
      lines.back() += "; " + part;
    at = end + 2;
  }
  return lines;
}

}  // namespace

Result<Image> render_section(const Section& section, int width) {
  if (width < 320 || width > 16384)
    return fail(Code::BadParameter, "found a width of " + std::to_string(width) + "; allowed 320 .. 16384 pixels");
  const double text = std::clamp(width / 96.0, 8.0, 60.0);
  const double room = width - 3.2 * text;
  const std::vector<std::string> figures = wrapped(section_figures(section), 0.92 * text, room);
  const Window w = window_of(section, width, text, static_cast<double>(figures.size()));
  Image image(width, static_cast<int>(w.top + w.height + 4.2 * text), kPaper);
  draw_text(image, 1.6 * text, 2.6 * text, text_within(section.frame.name, 1.25 * text, room), 1.25 * text, kInk);
  for (std::size_t n = 0; n < figures.size(); ++n)
    draw_text(image, 1.6 * text, (4.8 + 1.7 * static_cast<double>(n)) * text,
              text_within(figures[n], 0.92 * text, room), 0.92 * text, kFaintInk);
  std::vector<Segment> dots;
  for (const SectionPoint& point : section.points) dots.push_back(w.between(point.at, point.at));
  draw_strokes(image, dots, std::max(2.0, text / 4.5), kSlabPoint);
  draw_deviations(section, w, std::max(0.9, text / 11), image);
  draw_lines(section, w, std::max(1.5, text / 6), image);
  if (section.worst) draw_worst(section, w, text, image);
  draw_bar(w, text, image);
  draw_directions(section.frame, text, image);
  return image;
}

}  // namespace scanmill::render
