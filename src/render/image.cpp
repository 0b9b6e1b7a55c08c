// SPDX-License-Identifier: Apache-2.0
#include "render/image.hpp"

namespace scanmill::render {

Image::Image(int w, int h, Rgb fill)
    : width(w), height(h), rgb(static_cast<std::size_t>(w) * static_cast<std::size_t>(h) * 3) {
  for (std::size_t i = 0; i < rgb.size(); i += 3) {
    rgb[i] = fill.r;
    rgb[i + 1] = fill.g;
    rgb[i + 2] = fill.b;
  }
}

}  // namespace scanmill::render
