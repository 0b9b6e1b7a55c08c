// SPDX-License-Identifier: Apache-2.0
// What all mesh readers share: vertices and polygons come in, checked, counted, and leave as a MeshFile.
#pragma once
#include <span>
#include <string_view>

#include "formats/mesh_reader.hpp"

namespace scanmill::formats {

/// Where something stands in a file: a line of a text, or a byte.
struct Place {
  bool is_line = true;
  std::uint64_t number = 0;
  std::string text(const std::string& file) const;
};

class MeshBuilder {
 public:
  explicit MeshBuilder(const std::string& name) : name_(name) {}

  MeshFile mesh;

  std::uint64_t vertex_count() const { return mesh.positions.size(); }
  /// errors  Unsupported when 32 bits can no longer number the vertices
  Result<void> add_vertex(Vec3 position);
  /// Corners as rows from 0; they are checked against the vertices at the end, since a file may name vertices that come
  /// later.
  void add_polygon(std::span<const std::uint64_t> corners, Place place);
  void add_comment(std::string_view text);
  /// One sentence, once; beyond twenty they are dropped.
  void note(std::string text);
  /// Something on vertices or faces that is read over.
  void skipped(const std::string& property);

  /// errors  BadInput: a face names a vertex that is not there, or one that is not finite
  Result<MeshFile> finish();

 private:
  Result<void> drop_not_finite();

  const std::string& name_;
  std::uint64_t greatest_ = 0, not_finite_ = 0;
  bool any_corner_ = false;
  Place greatest_place_;
};

/// The three numbers behind the word offset_mm, if the text has them.
std::optional<Vec3> offset_in(std::string_view text);

/// The readers behind read_mesh.
Result<MeshFile> read_stl_mesh(const ByteSource& source);
Result<MeshFile> read_obj_mesh(const ByteSource& source);
Result<MeshFile> read_off_mesh(const ByteSource& source);
Result<MeshFile> read_ply_mesh(const ByteSource& source);

/// Whether the size is the one that the count of a binary STL asks for.
bool is_binary_stl(std::string_view first_bytes, std::uint64_t size);
/// Whether a word is the keyword of an OFF file: any of ST, C, N, 4, n before OFF.
bool is_off_keyword(std::string_view word);

}  // namespace scanmill::formats
