// SPDX-License-Identifier: Apache-2.0
// Files of triangles: STL, OBJ, OFF, PLY with faces.
#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/bytes.hpp"
#include "mesh/mesh.hpp"

namespace scanmill::formats {

enum class MeshKind { None, Stl, Obj, Off, Ply };

/// How the file holds its coordinates.
enum class CoordinateForm { Float32, Float64, Text };

/// A mesh as its file says: positions in the file's units, nothing moved, nothing dropped that makes up the mesh.
struct MeshFile {
  std::string format;  // "stl binary", "stl ascii", "obj", "off" (with its letters: "coff"), "ply ascii", ...
  CoordinateForm coordinates = CoordinateForm::Text;
  std::vector<Vec3> positions;  // all finite; the offset is not added
  /// Corners in the order of the file. Polygons are split into fans from their first corner.
  std::vector<Triangle> triangles;
  std::vector<std::uint32_t> patch;     // per triangle, or empty
  std::vector<double> error;            // per vertex, mm, signed, or empty
  std::vector<double> error_rms;        // per vertex, mm, or empty
  std::optional<Vec3> offset;           // what the file says must be added for the global frame
  std::uint64_t polygons_split = 0;     // faces of more than three corners
  std::uint64_t faces_left_out = 0;     // faces of fewer than three corners
  std::uint64_t repeated_corners = 0;   // triangles that name a vertex twice; they stay in `triangles`
  std::vector<std::string> properties;  // what else hangs on vertices and faces: read over, lost in any conversion
  std::vector<std::string> comments;    // at most kMaxComments
  std::vector<std::string> notes;       // what was skipped or repaired, one sentence each
};

inline constexpr std::size_t kMaxComments = 100;

/// Judged by content, then by the suffix of the source's name. A PLY counts whether or not it has faces.
/// errors  those of the source
Result<MeshKind> mesh_kind_of(const ByteSource& source);

/// A binary STL is known by its size (84 + 50 n), whatever its header says; its corners are joined where their float32
/// coordinates are exactly equal (-0 is 0). Vertices that are not finite are dropped when no face uses them.
/// Memory follows the bytes that are there, never what a header claims.
/// errors  BadInput naming "file:line" or "file: byte N": a cut file, a count that the bytes cannot hold, an index out
///         of range, a face on a vertex that is not finite, no mesh in the file; Unsupported for OFF in binary or of
///         other than three dimensions, and from 2^32 - 1 vertices on
Result<MeshFile> read_mesh(std::shared_ptr<const ByteSource> source);

/// The mesh of a file for the stages that judge and draw: every triangle with its smallest row first, triangles in
/// ascending order, patch 0 where the file has none. Positions and offset as in the file.
Mesh mesh_of(const MeshFile& file);

}  // namespace scanmill::formats
