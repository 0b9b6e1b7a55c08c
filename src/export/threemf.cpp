// SPDX-License-Identifier: Apache-2.0
#include "export/threemf.hpp"

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "base/text.hpp"
#include "export/comparing_sink.hpp"
#include "export/little_endian.hpp"
#include "export/patch_colours.hpp"
#include "export/text_buffer.hpp"
#include "export/zip.hpp"

namespace scanmill::exporting {
namespace {

constexpr std::string_view kTypes =
    "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
    "<Types xmlns=\"http://schemas.openxmlformats.org/package/2006/content-types\">"
    "<Default Extension=\"rels\" ContentType=\"application/vnd.openxmlformats-package.relationships+xml\"/>"
    "<Default Extension=\"model\" ContentType=\"application/vnd.ms-package.3dmanufacturing-3dmodel+xml\"/></Types>\n";
constexpr std::string_view kRelations =
    "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
    "<Relationships xmlns=\"http://schemas.openxmlformats.org/package/2006/relationships\">"
    "<Relationship Id=\"rel0\" Target=\"/3D/3dmodel.model\" "
    "Type=\"http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel\"/></Relationships>\n";

bool names_twice(const Triangle& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; }

std::string hex_colour(std::uint32_t patch) {
  constexpr std::string_view kDigits = "0123456789ABCDEF";
  std::string text = "#";
  for (const std::uint8_t c : patch_colour(patch)) {
    text += kDigits[c >> 4];
    text += kDigits[c & 15];
  }
  return text;
}

void put_head(const MeshStream& mesh, const std::vector<std::uint32_t>& ids, bool closed, std::string& text) {
  text +=
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
      "<model unit=\"millimeter\" xml:lang=\"en-US\" "
      "xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\" xmlns:scanmill=\"urn:scanmill\">\n"
      " <metadata name=\"Application\">scanmill</metadata>\n";
  if (const Vec3 o = mesh.offset(); !(o == Vec3{}))
    text += " <metadata name=\"scanmill:offset_mm\">" + number_text(o.x) + " " + number_text(o.y) + " " +
            number_text(o.z) + "</metadata>\n";
  text += " <resources>\n";
  if (!ids.empty()) {
    text += "  <basematerials id=\"1\">\n";
    for (const std::uint32_t id : ids)
      text += "   <base name=\"patch_" + std::to_string(id) + "\" displaycolor=\"" + hex_colour(id) + "\"/>\n";
    text += "  </basematerials>\n";
  }
  text += "  <object id=\"2\" type=\"" + std::string(closed ? "model" : "surface") + "\"" +
          (ids.empty() ? "" : " pid=\"1\" pindex=\"0\"") + ">\n   <mesh>\n    <vertices>\n";
}

Result<void> put_vertices(const MeshStream& mesh, TextBuffer& out) {
  TRY(mesh.each_vertices([&](std::span<const Vec3> positions) -> Result<void> {
    for (const Vec3& p : positions) {
      out.text("<vertex x=\"").number(without_minus_zero(p.x)).text("\" y=\"").number(without_minus_zero(p.y));
      out.text("\" z=\"").number(without_minus_zero(p.z)).text("\"/>\n");
      TRY(out.flush_when_full());
    }
    return {};
  }));
  out.text("    </vertices>\n");
  return {};
}

Result<void> put_triangles(const MeshStream& mesh, const std::vector<std::uint32_t>& ids, TextBuffer& out) {
  out.text("    <triangles>\n");
  TRY(mesh.each_triangles(Corners::No, [&](const TriangleBlock& block) -> Result<void> {
    for (std::size_t t = 0; t < block.rows.size(); ++t) {
      const Triangle& corners = block.rows[t];
      if (names_twice(corners)) continue;
      out.text("<triangle v1=\"").number(corners[0]).text("\" v2=\"").number(corners[1]);
      out.text("\" v3=\"").number(corners[2]);
      if (!ids.empty()) {
        const auto place = std::lower_bound(ids.begin(), ids.end(), block.patch[t]) - ids.begin();
        if (place > 0) out.text("\" pid=\"1\" p1=\"").number(place);  // the first is the object's own
      }
      out.text("\"/>\n");
      TRY(out.flush_when_full());
    }
    return {};
  }));
  out.text("    </triangles>\n   </mesh>\n  </object>\n </resources>\n");
  out.text(" <build>\n  <item objectid=\"2\"/>\n </build>\n</model>\n");
  return {};
}

Result<void> write_model(const MeshStream& mesh, bool closed, ByteSink& sink) {
  const std::vector<std::uint32_t> ids = mesh.patch_ids();
  std::string head;
  put_head(mesh, ids, closed, head);
  TRY(sink.write(std::string_view(head)));
  TextBuffer out(sink);
  TRY(put_vertices(mesh, out));
  TRY(put_triangles(mesh, ids, out));
  return out.flush();
}

}  // namespace

Result<ThreeMfCounts> write_3mf(const Mesh& mesh, ByteSink& sink) {
  TRY(check_patches(mesh, sink.name()));
  return stream_3mf(MeshBlocks(mesh), sink);
}

Result<ThreeMfCounts> stream_3mf(const MeshStream& mesh, ByteSink& sink) {
  if (mesh.triangles() == 0) return fail(Code::BadInput, "the mesh has no triangle to write", sink.name());
  ThreeMfCounts counts;
  TRY(mesh.each_triangles(Corners::No, [&](const TriangleBlock& block) -> Result<void> {
    counts.left_out += static_cast<std::uint64_t>(std::count_if(block.rows.begin(), block.rows.end(), names_twice));
    return {};
  }));
  counts.triangles = mesh.triangles() - counts.left_out;
  counts.closed = mesh.is_closed();
  ZipWriter package(sink);
  TRY(package.add("[Content_Types].xml", [](ByteSink& part) { return part.write(kTypes); }));
  TRY(package.add("_rels/.rels", [](ByteSink& part) { return part.write(kRelations); }));
  TRY(package.add("3D/3dmodel.model", [&](ByteSink& part) { return write_model(mesh, counts.closed, part); }));
  TRY(package.finish());
  return counts;
}

Result<void> compare_3mf(const Mesh& mesh, const ByteSource& source) {
  ComparingSink sink(source);
  TRY(write_3mf(mesh, sink));
  return sink.commit();
}

}  // namespace scanmill::exporting
