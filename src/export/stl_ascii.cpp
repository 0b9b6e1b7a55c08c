// SPDX-License-Identifier: Apache-2.0
#include "base/text.hpp"
#include "export/comparing_sink.hpp"
#include "export/facet.hpp"
#include "export/mesh_writers.hpp"
#include "export/text_buffer.hpp"

namespace scanmill::exporting {

Result<void> write_stl_ascii(const Mesh& mesh, ByteSink& sink) { return stream_stl_ascii(MeshBlocks(mesh), sink); }

Result<void> stream_stl_ascii(const MeshStream& mesh, ByteSink& sink) {
  std::string title = "scanmill UNITS=mm";
  if (const Vec3 o = mesh.offset(); !(o == Vec3{}))
    title += " offset_mm " + number_text(o.x) + " " + number_text(o.y) + " " + number_text(o.z);
  TextBuffer out(sink);
  auto triple = [&](std::string_view before, FloatCorner c) {
    out.text(before).number(c.x).text(" ").number(c.y).text(" ").number(c.z);
  };
  out.text("solid ").text(title).text("\n");
  TRY(mesh.each_triangles(Corners::Yes, [&](const TriangleBlock& block) -> Result<void> {
    for (const auto& corners : block.corners) {
      const FloatCorner a = corner_of(corners[0]), b = corner_of(corners[1]), c = corner_of(corners[2]);
      triple("  facet normal ", normal_of(a, b, c));
      out.text("\n    outer loop\n");
      for (const FloatCorner& corner : {a, b, c}) {
        triple("      vertex ", corner);
        out.text("\n");
      }
      out.text("    endloop\n  endfacet\n");
      TRY(out.flush_when_full());
    }
    return {};
  }));
  out.text("endsolid scanmill\n");
  return out.flush();
}

Result<void> compare_stl_ascii(const Mesh& mesh, const ByteSource& source) {
  ComparingSink sink(source);
  TRY(write_stl_ascii(mesh, sink));
  return sink.commit();
}

}  // namespace scanmill::exporting
