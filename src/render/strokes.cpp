// SPDX-License-Identifier: Apache-2.0
#include "render/strokes.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "render/glyphs.hpp"

namespace scanmill::render {
namespace {

constexpr double kPenOfSize = 0.155;  // thickness of the pen, in capitals

/// The character at `at`, which moves behind it; bytes that are no UTF-8 count one by one as U+FFFD.
char32_t next_character(std::string_view text, std::size_t& at) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned lead = byte(at++);
  if (lead < 0x80) return lead;
  const int more = lead >= 0xf0 && lead < 0xf8   ? 3
                   : lead >= 0xe0 && lead < 0xf0 ? 2
                   : lead >= 0xc2 && lead < 0xe0 ? 1
                                                 : 0;
  if (more == 0 || at + static_cast<std::size_t>(more) > text.size()) return 0xfffd;
  char32_t value = lead & (0x3fu >> more);
  for (int k = 0; k < more; ++k) {
    if ((byte(at + static_cast<std::size_t>(k)) & 0xc0) != 0x80) return 0xfffd;
    value = value << 6 | (byte(at + static_cast<std::size_t>(k)) & 0x3fu);
  }
  at += static_cast<std::size_t>(more);
  return value;
}

double distance2(const Segment& s, double x, double y) {
  const double dx = s.x1 - s.x0, dy = s.y1 - s.y0, length2 = dx * dx + dy * dy;
  double t = length2 > 0 ? ((x - s.x0) * dx + (y - s.y0) * dy) / length2 : 0;
  t = std::clamp(t, 0.0, 1.0);
  const double ex = x - (s.x0 + t * dx), ey = y - (s.y0 + t * dy);
  return ex * ex + ey * ey;
}

/// [low, high] in pixels as a range of pixel numbers inside [0, size).
std::pair<int, int> pixels_between(double low, double high, int size) {
  const double from = std::clamp(std::floor(low), 0.0, static_cast<double>(size));
  const double to = std::clamp(std::floor(high) + 1, from, static_cast<double>(size));
  return {static_cast<int>(from), static_cast<int>(to)};
}

}  // namespace

void draw_strokes(Image& image, std::span<const Segment> segments, double width, Rgb colour) {
  if (segments.empty()) return;
  const double half = width / 2, reach = half + 0.5;
  double low_x = segments[0].x0, high_x = low_x, low_y = segments[0].y0, high_y = low_y;
  for (const Segment& s : segments) {
    low_x = std::min({low_x, s.x0, s.x1});
    high_x = std::max({high_x, s.x0, s.x1});
    low_y = std::min({low_y, s.y0, s.y1});
    high_y = std::max({high_y, s.y0, s.y1});
  }
  const auto [x0, x1] = pixels_between(low_x - reach, high_x + reach, image.width);
  const auto [y0, y1] = pixels_between(low_y - reach, high_y + reach, image.height);
  if (x0 >= x1 || y0 >= y1) return;
  const auto columns = static_cast<std::size_t>(x1 - x0);
  std::vector<double> cover(columns * static_cast<std::size_t>(y1 - y0), 0);
  for (const Segment& s : segments) {
    const auto [sx0, sx1] = pixels_between(std::min(s.x0, s.x1) - reach, std::max(s.x0, s.x1) + reach, image.width);
    const auto [sy0, sy1] = pixels_between(std::min(s.y0, s.y1) - reach, std::max(s.y0, s.y1) + reach, image.height);
    for (int y = sy0; y < sy1; ++y)
      for (int x = sx0; x < sx1; ++x) {
        double& c = cover[static_cast<std::size_t>(y - y0) * columns + static_cast<std::size_t>(x - x0)];
        c = std::max(c, std::clamp(reach - std::sqrt(distance2(s, x + 0.5, y + 0.5)), 0.0, 1.0));
      }
  }
  const int ink[3] = {colour.r, colour.g, colour.b};
  for (int y = y0; y < y1; ++y)
    for (int x = x0; x < x1; ++x) {
      const double c = cover[static_cast<std::size_t>(y - y0) * columns + static_cast<std::size_t>(x - x0)];
      std::uint8_t* p = image.at(x, y);
      for (int k = 0; k < 3; ++k) p[k] = static_cast<std::uint8_t>(p[k] + (ink[k] - p[k]) * c + 0.5);
    }
}

void fill_box(Image& image, double x0, double y0, double x1, double y1, Rgb colour) {
  const auto [from_x, to_x] = pixels_between(x0 + 0.5, x1 - 0.5, image.width);
  const auto [from_y, to_y] = pixels_between(y0 + 0.5, y1 - 0.5, image.height);
  for (int y = from_y; y < to_y; ++y)
    for (int x = from_x; x < to_x; ++x) {
      image.at(x, y)[0] = colour.r;
      image.at(x, y)[1] = colour.g;
      image.at(x, y)[2] = colour.b;
    }
}

double text_width(std::string_view text, double size) {
  int units = 0;
  for (std::size_t at = 0; at < text.size();) units += glyph_of(next_character(text, at)).width + kGap;
  return std::max(0, units - kGap) * (size / kCapitals);
}

void draw_text(Image& image, double x, double y, std::string_view text, double size, Rgb colour, Align align) {
  const double unit = size / kCapitals;
  if (align != Align::Left) x -= text_width(text, size) * (align == Align::Middle ? 0.5 : 1);
  std::vector<Segment> pen;
  for (std::size_t at = 0; at < text.size();) {
    const Glyph glyph = glyph_of(next_character(text, at));
    bool drawing = false;
    double from_x = 0, from_y = 0;
    for (std::size_t i = 0; i + 1 < glyph.strokes.size(); i += 3) {
      const double to_x = x + (glyph.strokes[i] - '0') * unit;
      const double to_y = y - (glyph.strokes[i + 1] - '0' - kBaseLine) * unit;
      const bool ends = i + 2 >= glyph.strokes.size() || glyph.strokes[i + 2] == ',';
      if (drawing)
        pen.push_back({from_x, from_y, to_x, to_y});
      else if (ends)
        pen.push_back({to_x, to_y, to_x, to_y});
      drawing = !ends;
      from_x = to_x;
      from_y = to_y;
    }
    x += (glyph.width + kGap) * unit;
  }
  draw_strokes(image, pen, std::max(1.1, kPenOfSize * size), colour);
}

std::string text_within(std::string_view text, double size, double width) {
  if (text_width(text, size) <= width) return std::string(text);
  std::size_t end = 0;
  for (std::size_t at = 0; at < text.size();) {
    next_character(text, at);
    if (text_width(std::string(text.substr(0, at)) + "...", size) > width) break;
    end = at;
  }
  return std::string(text.substr(0, end)) + "...";
}

}  // namespace scanmill::render
