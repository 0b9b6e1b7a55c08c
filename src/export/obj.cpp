// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <numeric>

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
  const bool has_patches = !mesh.patch.empty();
  if (has_patches && mesh.patch.size() != mesh.triangles.size())
    return fail(Code::Internal,
                grouped(mesh.triangles.size()) + " triangles have " + grouped(mesh.patch.size()) + " patch ids",
                sink.name());
  TextBuffer out(sink);
  out.text("# scanmill mesh, units mm\n");
  if (!(mesh.offset == Vec3{}))
    out.text("# offset_mm ")
        .number(mesh.offset.x)
        .text(" ")
        .number(mesh.offset.y)
        .text(" ")
        .number(mesh.offset.z)
        .text("\n");
  for (const Vec3& p : mesh.positions) {
    out.text("v ").number(without_minus_zero(p.x)).text(" ").number(without_minus_zero(p.y)).text(" ");
    out.number(without_minus_zero(p.z)).text("\n");
    TRY(out.flush_when_full());
  }
  const std::vector<std::size_t> order = order_by_patch(mesh);
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const std::size_t t = order.empty() ? i : order[i];
    if (has_patches && (i == 0 || mesh.patch[t] != mesh.patch[order.empty() ? i - 1 : order[i - 1]]))
      out.text("g patch_").number(mesh.patch[t]).text("\n");
    out.text("f");
    for (const std::uint32_t corner : mesh.triangles[t]) out.text(" ").number(std::uint64_t{corner} + 1);
    out.text("\n");
    TRY(out.flush_when_full());
  }
  return out.flush();
}

Result<void> compare_obj(const Mesh& mesh, const ByteSource& source) {
  ComparingSink sink(source);
  TRY(write_obj(mesh, sink));
  return sink.commit();
}

}  // namespace scanmill::exporting
