// SPDX-License-Identifier: Apache-2.0
// A section as a picture.
#pragma once
#include "base/result.hpp"
#include "mesh/section.hpp"
#include "render/image.hpp"

namespace scanmill::render {

/// `width` pixels wide and as high as the section needs, between a quarter and the whole of that: the mesh's line, the
/// measured points of the slab, their deviations magnified (red outside, blue inside), the worst one ringed with its
/// figure, a scale bar.
/// errors  BadParameter for a width outside 320 .. 16384
Result<Image> render_section(const Section& section, int width);

}  // namespace scanmill::render
