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

/// The mesh's lines where they lie in space, mm, as IGES: a curve (126 of degree 1, since the lines are straight between
/// the mesh's edges; closed where the line is) each, places to the last bit; per section N a group (402 form 7), level
/// N, a colour (314) and the name `section_N` (406 form 15); the start section says which plane N is.
Result<void> write_sections_iges(std::span<const Section> sections, ByteSink& sink);

}  // namespace scanmill::exporting
