// SPDX-License-Identifier: Apache-2.0
// Sections as files: a sheet of drawings (SVG) and lines in space (DXF). The same bytes every time.
#pragma once
#include <span>

#include "base/bytes.hpp"
#include "mesh/section.hpp"

namespace scanmill::exporting {

/// One panel per section, one below the other: the mesh's line, the measured points of the slab, their deviations
/// magnified (red outside, blue inside), the worst one ringed with its figure, a scale bar. Text as UTF-8, nothing
/// fetched.
Result<void> write_sections_svg(std::span<const Section> sections, ByteSink& sink);

/// Everything where it lies in space, mm: per section N the layers SECTION_N_MESH (polylines), _POINTS (where they were
/// measured), _DEVIATION (lines, magnified as the layer's comment says) and _WORST (a cross and its figure).
Result<void> write_sections_dxf(std::span<const Section> sections, ByteSink& sink);

}  // namespace scanmill::exporting
