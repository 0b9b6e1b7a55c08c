// SPDX-License-Identifier: Apache-2.0
#include "export/mesh_stream.hpp"

#include <algorithm>

#include "base/text.hpp"
#include "export/shells.hpp"

namespace scanmill::exporting {
namespace {

constexpr std::size_t kAtOnce = 8192;

}  // namespace

Bounds MeshBlocks::bounds() const {
  Bounds box;
  for (const Vec3& p : mesh_.positions) box.add(p);
  return box;
}

std::vector<std::uint32_t> MeshBlocks::patch_ids() const {
  std::vector<std::uint32_t> ids(mesh_.patch.begin(), mesh_.patch.end());
  std::sort(ids.begin(), ids.end());
  ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
  return ids;
}

bool MeshBlocks::is_closed() const {
  const Shells shells = shells_of(mesh_);
  return std::all_of(shells.shells.begin(), shells.shells.end(), [](const Shell& shell) { return shell.closed; });
}

Result<void> MeshBlocks::each_vertices(OnVertices visit) const { return visit(mesh_.positions); }

Result<void> MeshBlocks::each_triangles(Corners wanted, OnTriangles visit) const {
  std::vector<Triangle> rows;
  std::vector<std::array<Vec3, 3>> corners;
  std::vector<std::uint32_t> patch;
  const std::size_t count = mesh_.triangles.size();
  for (std::size_t first = 0; first < count; first += kAtOnce) {
    const std::size_t size = std::min(kAtOnce, count - first);
    TriangleBlock block{std::span(mesh_.triangles).subspan(first, size), {}, {}};
    if (!mesh_.patch.empty()) block.patch = std::span(mesh_.patch).subspan(first, size);
    if (!order_.empty()) {
      rows.clear();
      patch.clear();
      for (const std::size_t t : order_.subspan(first, size)) {
        rows.push_back(mesh_.triangles[t]);
        if (!mesh_.patch.empty()) patch.push_back(mesh_.patch[t]);
      }
      block.rows = rows;
      block.patch = patch;
    }
    if (wanted == Corners::Yes) {
      corners.clear();
      for (const Triangle& t : block.rows)
        corners.push_back({mesh_.positions[t[0]], mesh_.positions[t[1]], mesh_.positions[t[2]]});
      block.corners = corners;
    }
    TRY(visit(block));
  }
  return {};
}

Result<void> check_patches(const Mesh& mesh, const std::string& name) {
  if (mesh.patch.empty() || mesh.patch.size() == mesh.triangles.size()) return {};
  return fail(Code::Internal,
              grouped(mesh.triangles.size()) + " triangles have " + grouped(mesh.patch.size()) + " patch ids", name);
}

}  // namespace scanmill::exporting
