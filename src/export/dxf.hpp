// SPDX-License-Identifier: Apache-2.0
// Drawings as DXF R12 (ASCII), which every reader of DXF takes: millimetres, a layer with a colour per patch.
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/bytes.hpp"
#include "export/mesh_stream.hpp"
#include "export/text_buffer.hpp"
#include "mesh/mesh.hpp"

namespace scanmill::exporting {

/// Faces: a 3DFACE per triangle. Polyface: polyface meshes with shared vertices, one per patch, and per 32,767 vertices
/// of it, which is what the format numbers.
enum class DxfStyle : std::int32_t { Faces, Polyface };
std::span<const std::string_view> dxf_style_words();

struct DxfLayer {
  std::string name;  // letters, digits, '_', '-', '$'
  int colour = 7;    // AutoCAD colour index
};

/// The parts of a drawing, in order. Reals have the shortest text that reads back to the same double, without exponent
/// where that is possible.
class DxfWriter {
 public:
  explicit DxfWriter(ByteSink& sink) : out_(sink) {}
  /// Header, tables and the beginning of the entities. `comments` are lines of group 999.
  Result<void> begin(const Bounds& bounds, std::span<const DxfLayer> layers, std::span<const std::string> comments);
  Result<void> face(std::string_view layer, Vec3 a, Vec3 b, Vec3 c);
  /// A polyline in space; `closed` joins its ends.
  Result<void> polyline(std::string_view layer, std::span<const Vec3> points, bool closed);
  Result<void> line(std::string_view layer, Vec3 from, Vec3 to);
  Result<void> point(std::string_view layer, Vec3 place);
  /// One line of text, `height` mm high, in the plane through `place` that x and y span.
  Result<void> text(std::string_view layer, Vec3 place, double height, std::string_view words);
  /// At most 32,767 vertices; triangles name rows of `vertices`.
  Result<void> polyface(std::string_view layer, std::span<const Vec3> vertices, std::span<const Triangle> triangles);
  /// The end of the file; does not commit the sink.
  Result<void> end();

 private:
  void group(int code, std::string_view value);
  void group(int code, std::int64_t value);
  void real(int code, double value);
  void place(int first_code, Vec3 p);
  TextBuffer out_;
};

/// The colour index that comes nearest to a patch's colour in the pictures.
int dxf_colour(std::uint32_t patch);

/// errors  BadInput without triangles; Internal when patch ids do not fit the mesh; those of the sink
Result<void> write_dxf(const Mesh& mesh, DxfStyle style, ByteSink& sink);
/// Style Faces of a mesh in blocks.
Result<void> stream_dxf_faces(const MeshStream& mesh, ByteSink& sink);

/// Byte for byte comparison of a file, read again, with what the mesh it was written from gives.
/// errors  Internal naming the first byte that differs; those of the source
Result<void> compare_dxf(const Mesh& mesh, DxfStyle style, const ByteSource& source);

}  // namespace scanmill::exporting
