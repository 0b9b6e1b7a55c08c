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
#include "export/shells.hpp"
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

std::vector<std::uint32_t> patch_ids(const Mesh& mesh) {
  std::vector<std::uint32_t> ids(mesh.patch.begin(), mesh.patch.end());
  std::sort(ids.begin(), ids.end());
  ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
  return ids;
}

void put_head(const Mesh& mesh, const std::vector<std::uint32_t>& ids, bool closed, std::string& text) {
  text +=
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
      "<model unit=\"millimeter\" xml:lang=\"en-US\" "
      "xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\" xmlns:scanmill=\"urn:scanmill\">\n"
      " <metadata name=\"Application\">scanmill</metadata>\n";
  if (!(mesh.offset == Vec3{}))
    text += " <metadata name=\"scanmill:offset_mm\">" + number_text(mesh.offset.x) + " " + number_text(mesh.offset.y) +
            " " + number_text(mesh.offset.z) + "</metadata>\n";
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

Result<void> put_vertices(const Mesh& mesh, TextBuffer& out) {
  for (const Vec3& p : mesh.positions) {
    out.text("<vertex x=\"").number(without_minus_zero(p.x)).text("\" y=\"").number(without_minus_zero(p.y));
    out.text("\" z=\"").number(without_minus_zero(p.z)).text("\"/>\n");
    TRY(out.flush_when_full());
  }
  out.text("    </vertices>\n");
  return {};
}

Result<void> put_triangles(const Mesh& mesh, const std::vector<std::uint32_t>& ids, TextBuffer& out) {
  out.text("    <triangles>\n");
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Triangle& corners = mesh.triangles[t];
    if (names_twice(corners)) continue;
    out.text("<triangle v1=\"").number(corners[0]).text("\" v2=\"").number(corners[1]);
    out.text("\" v3=\"").number(corners[2]);
    if (!ids.empty()) {
      const auto place = std::lower_bound(ids.begin(), ids.end(), mesh.patch[t]) - ids.begin();
      if (place > 0) out.text("\" pid=\"1\" p1=\"").number(place);  // the first is the object's own
    }
    out.text("\"/>\n");
    TRY(out.flush_when_full());
  }
  out.text("    </triangles>\n   </mesh>\n  </object>\n </resources>\n");
  out.text(" <build>\n  <item objectid=\"2\"/>\n </build>\n</model>\n");
  return {};
}

Result<void> write_model(const Mesh& mesh, bool closed, ByteSink& sink) {
  const std::vector<std::uint32_t> ids = patch_ids(mesh);
  std::string head;
  put_head(mesh, ids, closed, head);
  TRY(sink.write(std::string_view(head)));
  TextBuffer out(sink);
  TRY(put_vertices(mesh, out));
  TRY(put_triangles(mesh, ids, out));
  return out.flush();
}

bool is_closed(const Mesh& mesh) {
  const Shells shells = shells_of(mesh);
  return std::all_of(shells.shells.begin(), shells.shells.end(), [](const Shell& shell) { return shell.closed; });
}

}  // namespace

Result<ThreeMfCounts> write_3mf(const Mesh& mesh, ByteSink& sink) {
  if (mesh.triangles.empty()) return fail(Code::BadInput, "the mesh has no triangle to write", sink.name());
  if (!mesh.patch.empty() && mesh.patch.size() != mesh.triangles.size())
    return fail(Code::Internal,
                grouped(mesh.triangles.size()) + " triangles have " + grouped(mesh.patch.size()) + " patch ids",
                sink.name());
  ThreeMfCounts counts;
  counts.left_out =
      static_cast<std::uint64_t>(std::count_if(mesh.triangles.begin(), mesh.triangles.end(), names_twice));
  counts.triangles = mesh.triangles.size() - counts.left_out;
  counts.closed = is_closed(mesh);
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
