// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <numeric>
#include <optional>

#include "base/text.hpp"
#include "export/comparing_sink.hpp"
#include "export/little_endian.hpp"
#include "export/mesh_writers.hpp"
#include "export/text_buffer.hpp"

namespace scanmill::exporting {
namespace {

/// Triangles by (patch, number); empty where the mesh is in that order already.
std::vector<std::size_t> order_by_patch(const Mesh& mesh) {
  std::vector<std::size_t> order;
  if (std::is_sorted(mesh.patch.begin(), mesh.patch.end())) return order;
  order.resize(mesh.triangles.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return mesh.patch[a] < mesh.patch[b]; });
  return order;
}

}  // namespace

Result<void> write_obj(const Mesh& mesh, ByteSink& sink) {
  TRY(check_patches(mesh, sink.name()));
  const std::vector<std::size_t> order = order_by_patch(mesh);
  return stream_obj(MeshBlocks(mesh, order), sink);
}

Result<void> stream_obj(const MeshStream& mesh, ByteSink& sink) {
  TextBuffer out(sink);
  out.text("# scanmill mesh, units mm\n");
  if (const Vec3 o = mesh.offset(); !(o == Vec3{}))
    out.text("# offset_mm ").number(o.x).text(" ").number(o.y).text(" ").number(o.z).text("\n");
  TRY(mesh.each_vertices([&](std::span<const Vec3> positions) -> Result<void> {
    for (const Vec3& p : positions) {
      out.text("v ").number(without_minus_zero(p.x)).text(" ").number(without_minus_zero(p.y)).text(" ");
      out.number(without_minus_zero(p.z)).text("\n");
      TRY(out.flush_when_full());
    }
    return {};
  }));
  std::optional<std::uint32_t> group;
  TRY(mesh.each_triangles(Corners::No, [&](const TriangleBlock& block) -> Result<void> {
    for (std::size_t t = 0; t < block.rows.size(); ++t) {
      if (!block.patch.empty() && group != block.patch[t]) {
        group = block.patch[t];
        out.text("g patch_").number(*group).text("\n");
      }
      out.text("f");
      for (const std::uint32_t corner : block.rows[t]) out.text(" ").number(std::uint64_t{corner} + 1);
      out.text("\n");
      TRY(out.flush_when_full());
    }
    return {};
  }));
  return out.flush();
}

Result<void> compare_obj(const Mesh& mesh, const ByteSource& source) {
  ComparingSink sink(source);
  TRY(write_obj(mesh, sink));
  return sink.commit();
}

}  // namespace scanmill::exporting
