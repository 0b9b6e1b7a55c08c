// SPDX-License-Identifier: Apache-2.0
// Pictures as PNG files (wall around zlib).
#pragma once
#include "base/bytes.hpp"
#include "render/image.hpp"

namespace scanmill::render {

/// 8-bit RGB, not interlaced, no time and no text: the same bytes for the same picture and zlib. Does not commit the
/// sink. Per row the filter among none, left and up with the least sum of magnitudes, the first of equals.
/// errors  what the sink reports; BadParameter for a picture without pixels; Unsupported for one beyond 2 GB
Result<void> write_png(const Image& image, ByteSink& sink);

}  // namespace scanmill::render
