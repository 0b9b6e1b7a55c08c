// SPDX-License-Identifier: Apache-2.0
// A mesh as IGES 5.3, the same bytes every time: mm, fixed date, levels and colours per patch, positions to the last
// bit. An offset that is not zero stands in the start section as `offset_mm x y z` (add it for the global frame).
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "base/bytes.hpp"
#include "mesh/fitted.hpp"
#include "mesh/mesh.hpp"

namespace scanmill::exporting {

/// Brep: a solid (186) per closed component, an open shell (514 form 2) per other one, faces (510) on planes (190) with
/// shared edges (508, 504, 502, 110). Trimmed: a trimmed surface (144, 142, 102, 110, 128) per triangle. Patches: a
/// degenerate B-spline surface (128) per triangle, grouped per patch (402 form 7). Wire: a line (110) per edge, grouped
/// per patch. Surfaces: a trimmed cubic B-spline surface (144, 142, 128, 126) per chart of `surfaces`, the other
/// triangles as in Patches.
enum class IgesStyle : std::int32_t { Brep, Trimmed, Patches, Wire, Surfaces };
std::span<const std::string_view> iges_style_words();

struct IgesOptions {
  IgesStyle style = IgesStyle::Brep;
  std::optional<double> bin_mm;              // finest detail the mesh claims; bin_mm / 1e4 is the file's resolution
  bool forecast_only = false;                // counts everything, writes nothing
  const FittedSurfaces* surfaces = nullptr;  // of the mesh; style Surfaces only, and needed there
};

/// What a file holds.
struct IgesCounts {
  std::uint64_t solids = 0, shells = 0, faces = 0, edges = 0, groups = 0;
  std::uint64_t surfaces = 0;    // faces that are charts
  std::uint64_t left_out = 0;    // triangles without area (faces of trimmed and patches only)
  std::uint64_t inside_out = 0;  // closed components of negative volume, written as closed shells (514 form 1)
  std::uint64_t directory_lines = 0, parameter_lines = 0, bytes = 0;
};

/// Lines of one section that seven digits number.
inline constexpr std::uint64_t kIgesLines = 9'999'999;

/// Writes the mesh, or counts what it would write. Faces come in the order of the triangles, solids and shells in the
/// order of their least triangle. A face carries level (patch + 1), colour and the name `patch_N` of its patch.
///
/// errors  Unsupported when a section would need more than kIgesLines lines, with both counts and what would fit;
///         BadInput when Brep meets a triangle without area, or an edge with more than two triangles or two in the same
///         direction; Internal when patch ids do not fit the mesh, or style Surfaces has
///         none; those of the sink
/// cost    two passes over the mesh; about 60 bytes per triangle of memory; 33 MB per 20,000 triangles of file
Result<IgesCounts> write_iges(const Mesh& mesh, const IgesOptions& options, ByteSink& sink);

/// Byte for byte comparison of a file, read again, with what the mesh it was written from gives.
/// errors  Internal naming the first byte that differs; those of the source
Result<void> compare_iges(const Mesh& mesh, const IgesOptions& options, const ByteSource& source);

}  // namespace scanmill::exporting
