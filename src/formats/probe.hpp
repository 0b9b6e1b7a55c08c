// SPDX-License-Identifier: Apache-2.0
// What a file is, from its first bytes and its name; cheap enough for tens of thousands of files.
#pragma once
#include <string>
#include <string_view>

#include "base/bytes.hpp"

namespace scanmill::formats {

enum class FileKind {
  Ply,           // points, perhaps with faces
  Text,          // lines of numbers
  Pts,           // a count and lines of numbers
  Ptx,           // scans with poses as text
  Pcd,           // Point Cloud Library
  Las,           // LAS, not compressed
  DepthMap,      // PNG; points only with the numbers of the camera
  Fringes,       // text that names pictures of shifted fringes
  PoseMatrices,  // text: one or more 4x4 matrices
  Unsupported,   // a known format of points, meshes or images that this version does not read
  Other          // nothing we know
};

struct Probe {
  FileKind kind = FileKind::Other;
  std::string format;      // "ply", "text", "pcd", ..., or the name of the unsupported format
  bool has_faces = false;  // Ply with a face element that is not empty; STL, OBJ, OFF (see mesh_reader.hpp)
};

/// Lower-case text behind the last '.' of the last part of a path; empty when there is none.
std::string suffix_of(std::string_view path);

/// Whether a file of this suffix can be a scan, or is worth a note that it cannot be read. Others need not be opened.
bool is_point_suffix(std::string_view suffix);
bool is_unsupported_suffix(std::string_view suffix);
/// Of archives and compressed files, which may hold scans.
bool is_packed_suffix(std::string_view suffix);
/// A PNG of 16-bit grey, by its first bytes; false when it cannot be read.
bool is_depth_map(const ByteSource& source);

/// Judges by content first, then by the suffix of the source's name. Headers that are broken give the kind they claim
/// to be: opening the file then says what is wrong.
/// errors  those of the source
Result<Probe> probe(const ByteSource& source);

}  // namespace scanmill::formats
