// SPDX-License-Identifier: Apache-2.0
// Smooth lines and lettering on a finished picture.
#pragma once
#include <span>
#include <string>
#include <string_view>

#include "render/image.hpp"

namespace scanmill::render {

/// In pixels; (0, 0) is the upper left corner of the upper left pixel, y runs down.
struct Segment {
  double x0 = 0, y0 = 0, x1 = 0, y1 = 0;
};

/// All segments as one shape of round strokes `width` pixels thick, its border smoothed over a pixel. What lies outside
/// the picture is left out.
void draw_strokes(Image& image, std::span<const Segment> segments, double width, Rgb colour);

/// Every pixel whose centre lies in [x0, x1) x [y0, y1).
void fill_box(Image& image, double x0, double y0, double x1, double y1, Rgb colour);

enum class Align { Left, Middle, Right };

/// Width in pixels of UTF-8 text whose capitals are `size` pixels tall.
double text_width(std::string_view text, double size);
/// (x, y): the end or the middle of the base line. Characters without a glyph become boxes.
void draw_text(Image& image, double x, double y, std::string_view text, double size, Rgb colour,
               Align align = Align::Left);
/// The text, or its beginning with "..." so that it is not wider than `width` pixels.
std::string text_within(std::string_view text, double size, double width);

}  // namespace scanmill::render
