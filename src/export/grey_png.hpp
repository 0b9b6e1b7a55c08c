// SPDX-License-Identifier: Apache-2.0
// Grey images as PNG files: depth maps, fringe images.
#pragma once
#include <cstdint>
#include <span>

#include "base/bytes.hpp"

namespace scanmill::exporting {

/// Rows of `width` pixels from the top; bits is 8 or 16, values beyond are clamped. Not interlaced, no time and no
/// text: the same bytes for the same image and zlib. Does not commit the sink. errors  what the sink reports;
/// BadParameter for an image without pixels or with a row that is not whole
Result<void> write_grey_png(std::span<const std::uint16_t> pixels, std::uint32_t width, int bits, ByteSink& sink);

}  // namespace scanmill::exporting
