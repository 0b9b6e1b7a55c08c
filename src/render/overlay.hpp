// SPDX-License-Identifier: Apache-2.0
// What stands around the part: title, scale bar, axes, the error scale, messages. All in strips of their own, so that
// nothing lies over the part.
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "render/camera.hpp"
#include "render/image.hpp"

namespace scanmill::render {

struct Layout {
  double text = 10;  // height of capitals, pixels
  Box part;          // for the part itself
  Box legend;        // right of it; no width when there is none
  Box strip;         // below
  Box title;         // above; no height when there is none
};
/// `error_range_mm` > 0: with room for the error scale of that range.
Layout layout_of(int width, int height, bool with_title, double error_range_mm);

void draw_title(Image& image, const Layout& layout, std::string_view title);
/// Bar of 1, 2 or 5 times a power of ten mm.
void draw_scale_bar(Image& image, const Layout& layout, double px_per_mm);
void draw_axes(Image& image, const Layout& layout, const Axes& axes);
/// Right end of the strip, grey.
void draw_caption(Image& image, const Layout& layout, const std::vector<std::string>& lines);
/// Ticks with numbers in mm; shades beyond the ends.
void draw_error_scale(Image& image, const Layout& layout, double range_mm);
/// Lines of text in the middle of the part's box.
void draw_message(Image& image, const Layout& layout, const std::vector<std::string>& lines);

/// A length such as "0.05", "20" or "2,000" with as many decimals as `step` needs; "1e+12" beyond ten digits.
std::string length_text(double value, double step);

}  // namespace scanmill::render
