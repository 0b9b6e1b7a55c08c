// SPDX-License-Identifier: Apache-2.0
#include "verify/sides.hpp"

#include "geom/angles.hpp"

namespace scanmill::verify {
namespace {

/// Zero where there is no area.
Vec3 unit_normal(const Mesh& mesh, const Triangle& t) {
  const Vec3 a = mesh.positions[t[0]];
  const Vec3 n = cross(mesh.positions[t[1]] - a, mesh.positions[t[2]] - a);
  const double length = norm(n);
  return length > 0 ? n * (1 / length) : Vec3{};
}

}  // namespace

Sides::Sides(const Mesh& mesh)
    : mesh_(mesh),
      across_(across_of(edges_of(mesh.positions.size(), mesh.triangles), mesh.triangles.size())),
      normal_(mesh.positions.size()),
      on_open_edge_(mesh.positions.size(), 0),
      beside_border_(mesh.triangles.size(), 0) {
  std::vector<std::uint8_t> on_border(mesh.positions.size(), 0);
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const Triangle& corners = mesh.triangles[t];
    const Vec3 n = unit_normal(mesh, corners);
    const Vec3 at[3] = {mesh.positions[corners[0]], mesh.positions[corners[1]], mesh.positions[corners[2]]};
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t next = (k + 1) % 3;
      normal_[corners[k]] += n * degrees_between(at[next] - at[k], at[(k + 2) % 3] - at[k]);
      const std::uint32_t other = across_[3 * t + k];
      if (other == kOpenEdge) on_open_edge_[corners[k]] = on_open_edge_[corners[next]] = 1;
      if (other < kMostTriangles && !mesh.patch.empty() && mesh.patch[other] != mesh.patch[t])
        on_border[corners[k]] = on_border[corners[next]] = 1;
    }
  }
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (const std::uint32_t v : mesh.triangles[t]) beside_border_[t] |= on_border[v];
}

bool Sides::is_above(const Hit& hit, const Vec3& p) const {
  const Triangle& t = mesh_.triangles[hit.triangle];
  const auto feature = static_cast<std::size_t>(hit.feature);
  if (hit.feature == Feature::Face) {
    const Vec3 &a = mesh_.positions[t[0]], &b = mesh_.positions[t[1]], &c = mesh_.positions[t[2]];
    return dot(p - a, cross(b - a, c - a)) >= 0;
  }
  if (hit.feature >= Feature::CornerA) {
    const std::uint32_t v = t[feature - static_cast<std::size_t>(Feature::CornerA)];
    return dot(p - mesh_.positions[v], normal_[v]) >= 0;
  }
  const std::size_t e = feature - static_cast<std::size_t>(Feature::EdgeAB);
  Vec3 n = unit_normal(mesh_, t);
  if (const std::uint32_t other = across_[3 * hit.triangle + e]; other < kMostTriangles)
    n += unit_normal(mesh_, mesh_.triangles[other]);
  return dot(p - mesh_.positions[t[e]], n) >= 0;
}

bool Sides::at_open_border(const Hit& hit) const {
  if (hit.feature == Feature::Face) return false;
  const auto feature = static_cast<std::size_t>(hit.feature);
  if (hit.feature >= Feature::CornerA)
    return on_open_edge_[mesh_.triangles[hit.triangle][feature - static_cast<std::size_t>(Feature::CornerA)]] != 0;
  return across_[3 * hit.triangle + feature - static_cast<std::size_t>(Feature::EdgeAB)] == kOpenEdge;
}

}  // namespace scanmill::verify
