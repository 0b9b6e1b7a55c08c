// SPDX-License-Identifier: Apache-2.0
#include "mesh/coarser.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

namespace scanmill {
namespace {

constexpr std::uint64_t kCellBits = 21;      // of each axis in a key
constexpr double kMostCells = 1 << 20;       // along the longest side
constexpr double kAreaOfTriangle = 1 / 2.2;  // of a cell's face, in a surface that lies in all directions

struct Member {
  std::uint64_t cell = 0;
  double distance2 = 0;  // from the cell's centre
  std::uint32_t row = 0;
  friend bool operator<(const Member& a, const Member& b) {
    return std::tie(a.cell, a.distance2, a.row) < std::tie(b.cell, b.distance2, b.row);
  }
};

std::vector<Member> members_of(const Mesh& mesh, const Bounds& box, double cell_mm) {
  std::vector<Member> members(mesh.positions.size());
  for (std::uint32_t v = 0; v < members.size(); ++v) {
    const Vec3 d = (mesh.positions[v] - box.low) * (1 / cell_mm);
    const Vec3 low{std::floor(d.x), std::floor(d.y), std::floor(d.z)};
    const auto part = [](double at) { return static_cast<std::uint64_t>(at); };
    members[v] = {(part(low.x) << kCellBits | part(low.y)) << kCellBits | part(low.z),
                  norm2(d - low - Vec3{0.5, 0.5, 0.5}), v};
  }
  std::sort(members.begin(), members.end());
  return members;
}

/// Rows in the order of their vertices, so that neighbours stay near each other as in the fine mesh.
void join(const std::vector<Member>& members, CoarserMesh& to) {
  std::vector<std::uint32_t> standing(members.size());  // per vertex: the vertex that stands for it
  to.row_of.clear();
  for (std::size_t n = 0; n < members.size(); ++n) {
    const bool first = n == 0 || members[n].cell != members[n - 1].cell;
    standing[members[n].row] = first ? members[n].row : standing[members[n - 1].row];
    if (first) to.row_of.push_back(members[n].row);
  }
  std::sort(to.row_of.begin(), to.row_of.end());
  to.vertex.resize(members.size());
  for (std::uint32_t row = 0; row < to.row_of.size(); ++row) to.vertex[to.row_of[row]] = row;
  for (std::uint32_t v = 0; v < standing.size(); ++v) to.vertex[v] = to.vertex[standing[v]];
}

Vec3 normal_of(const Vec3& a, const Vec3& b, const Vec3& c) { return cross(b - a, c - a); }

void join_triangles(const Mesh& mesh, CoarserMesh& to) {
  std::vector<std::pair<Triangle, std::uint32_t>> found;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    Triangle x = mesh.triangles[t];
    const auto& at = mesh.positions;
    const Vec3 outside = normal_of(at[x[0]], at[x[1]], at[x[2]]);
    for (std::uint32_t& corner : x) corner = to.vertex[corner];
    if (x[0] == x[1] || x[1] == x[2] || x[2] == x[0]) continue;
    std::rotate(x.begin(), std::min_element(x.begin(), x.end()), x.end());
    const auto& row = to.row_of;
    if (dot(normal_of(at[row[x[0]]], at[row[x[1]]], at[row[x[2]]]), outside) < 0) std::swap(x[1], x[2]);
    found.emplace_back(x, t);
  }
  std::sort(found.begin(), found.end());
  to.triangles.clear();
  to.triangle.clear();
  for (const auto& [x, t] : found) {
    if (!to.triangles.empty() && to.triangles.back() == x) continue;
    to.triangles.push_back(x);
    to.triangle.push_back(t);
  }
}

/// Cells along the longest side at which about so many triangles are left: finer rather than coarser.
std::uint64_t first_cells(const Mesh& mesh, double longest, double most) {
  double area2 = 0;
  for (const Triangle& t : mesh.triangles)
    area2 += norm(normal_of(mesh.positions[t[0]], mesh.positions[t[1]], mesh.positions[t[2]]));
  const double cell2 = area2 / 2 / (most * kAreaOfTriangle);
  const double cells = cell2 > 0 ? longest / std::sqrt(cell2) : 1;
  return static_cast<std::uint64_t>(std::clamp(cells, 1.0, kMostCells));
}

}  // namespace

CoarserMesh coarser_mesh(const Mesh& mesh, std::uint64_t most_triangles) {
  CoarserMesh to;
  const std::uint64_t most = std::max<std::uint64_t>(most_triangles, 8);
  if (mesh.triangles.size() <= most) {
    to.row_of.resize(mesh.positions.size());
    std::iota(to.row_of.begin(), to.row_of.end(), 0u);
    to.vertex = to.row_of;
    to.triangles = mesh.triangles;
    to.triangle.resize(mesh.triangles.size());
    std::iota(to.triangle.begin(), to.triangle.end(), 0u);
    return to;
  }
  Bounds box;
  for (const Vec3& p : mesh.positions) box.add(p);
  const Vec3 size = box.size();
  const double longest = std::max({size.x, size.y, size.z});
  for (std::uint64_t cells = first_cells(mesh, longest, static_cast<double>(most));;) {
    to.cell_mm = longest > 0 ? longest / static_cast<double>(cells) : 1;
    join(members_of(mesh, box, to.cell_mm), to);
    join_triangles(mesh, to);
    const auto found = static_cast<double>(to.triangles.size());
    if (to.triangles.size() <= most || cells == 1) return to;
    const double wanted = static_cast<double>(cells) * std::sqrt(static_cast<double>(most) / found) * 0.97;
    cells = std::clamp<std::uint64_t>(static_cast<std::uint64_t>(wanted), 1, cells - 1);
  }
}

std::vector<std::pair<std::uint32_t, std::uint32_t>> open_edges(const Mesh& mesh) {
  const std::vector<std::uint32_t> across = edge_neighbours(mesh.positions.size(), mesh.triangles);
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (std::size_t e = 0; e < 3; ++e)
      if (across[3 * t + e] == kNoTriangle)
        edges.push_back(std::minmax({mesh.triangles[t][e], mesh.triangles[t][(e + 1) % 3]}));
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  return edges;
}

}  // namespace scanmill
