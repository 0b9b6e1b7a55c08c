// SPDX-License-Identifier: Apache-2.0
// The lettering: every glyph as a few pen strokes.
#pragma once
#include <string_view>

namespace scanmill::render {

/// Pen strokes separated by commas; a stroke is points separated by blanks, a point two digits x y on a grid with the
/// base line at y = 2, small letters up to 6, capitals up to 8, descenders down to 0. A single point is a dot. Empty: a
/// blank.
struct Glyph {
  std::string_view strokes;
  int width = 4;
};
inline constexpr int kBaseLine = 2, kCapitals = 6, kGap = 2;

/// A box for characters that have no glyph.
Glyph glyph_of(char32_t character);

}  // namespace scanmill::render
