// SPDX-License-Identifier: Apache-2.0
// Meshes to swap edges on, and what must hold of them.
#pragma once
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "base/random.hpp"
#include "mesh/limits.hpp"
#include "optimise/optimise.hpp"
#include "support/mesh_checker.hpp"
#include "support/meshing.hpp"
#include "support/shapes.hpp"

namespace scanmill::optimise {

using Edge = std::pair<std::uint32_t, std::uint32_t>;  // lesser vertex first
inline Edge edge_of(std::uint32_t a, std::uint32_t b) { return {std::min(a, b), std::max(a, b)}; }

inline Limits limits_of(double range_mm, double min_angle_deg = 5) { return {range_mm, cos_of_degrees(min_angle_deg)}; }

inline Result<Report> run(Mesh& mesh, const Params& params, const Limits& limits, int threads = 1) {
  const support::Workers workers(threads);
  return optimise(mesh, params, limits, workers.context());
}

inline void to_convention(Mesh& mesh) {
  for (Triangle& t : mesh.triangles) std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
  std::sort(mesh.triangles.begin(), mesh.triangles.end());
}

inline bool keeps_convention(const Mesh& mesh) {
  for (const Triangle& t : mesh.triangles)
    if (t[0] > t[1] || t[0] > t[2]) return false;
  return std::is_sorted(mesh.triangles.begin(), mesh.triangles.end());
}

inline double smallest_angle(const Mesh& mesh, const Triangle& t) {
  double least = 180;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3 u = unit(mesh.positions[t[(k + 1) % 3]] - mesh.positions[t[k]]),
               v = unit(mesh.positions[t[(k + 2) % 3]] - mesh.positions[t[k]]);
    least = std::min(least, std::acos(std::clamp(dot(u, v), -1.0, 1.0)) * 57.29577951308232);
  }
  return least;
}

/// Ascending.
inline std::vector<double> smallest_angles(const Mesh& mesh) {
  std::vector<double> angles;
  for (const Triangle& t : mesh.triangles) angles.push_back(smallest_angle(mesh, t));
  std::sort(angles.begin(), angles.end());
  return angles;
}
inline double angle_p5(const Mesh& mesh) {
  const auto angles = smallest_angles(mesh);
  return angles[angles.size() / 20];
}

/// Triangles at each edge.
inline std::map<Edge, std::vector<std::uint32_t>> edges_of(const Mesh& mesh) {
  std::map<Edge, std::vector<std::uint32_t>> edges;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
    for (std::size_t e = 0; e < 3; ++e)
      edges[edge_of(mesh.triangles[t][e], mesh.triangles[t][(e + 1) % 3])].push_back(t);
  return edges;
}

inline Vec3 normal_of(const Mesh& mesh, const Triangle& t) {
  return unit(cross(mesh.positions[t[1]] - mesh.positions[t[0]], mesh.positions[t[2]] - mesh.positions[t[0]]));
}

/// Draws edges and puts in their other diagonal where the quadrilateral is clearly convex, the diagonal new and not too
/// long, and no angle falls below 7 degrees. Returns the number of swaps.
inline std::size_t shuffle_diagonals(Mesh& mesh, double range_mm, std::size_t draws, std::uint64_t seed) {
  auto edges = edges_of(mesh);
  Random random(seed, 1, 1);
  std::size_t swaps = 0;
  for (std::size_t n = 0; n < draws; ++n) {
    const auto t = static_cast<std::uint32_t>(random.uniform() * static_cast<double>(mesh.triangles.size()));
    const auto e = static_cast<std::size_t>(random.uniform() * 3);
    const Triangle tri = mesh.triangles[t];
    const std::uint32_t a = tri[e], b = tri[(e + 1) % 3], c = tri[(e + 2) % 3];
    const auto& both = edges[edge_of(a, b)];
    if (both.size() != 2) continue;
    const std::uint32_t u = both[0] == t ? both[1] : both[0];
    std::uint32_t d = 0;
    for (const std::uint32_t v : mesh.triangles[u])
      if (v != a && v != b) d = v;
    if (c == d || edges.contains(edge_of(c, d)) || norm(mesh.positions[c] - mesh.positions[d]) > range_mm) continue;
    const Triangle x{c, d, b}, y{d, c, a};
    const Vec3 mean = unit(normal_of(mesh, tri) + normal_of(mesh, mesh.triangles[u]));
    if (dot(normal_of(mesh, x), mean) < 0.7 || dot(normal_of(mesh, y), mean) < 0.7) continue;
    if (smallest_angle(mesh, x) < 7 || smallest_angle(mesh, y) < 7) continue;
    edges.erase(edge_of(a, b));
    edges[edge_of(c, d)] = {t, u};
    std::replace(edges[edge_of(a, c)].begin(), edges[edge_of(a, c)].end(), t, u);
    std::replace(edges[edge_of(d, b)].begin(), edges[edge_of(d, b)].end(), u, t);
    mesh.triangles[t] = x;
    mesh.triangles[u] = y;
    ++swaps;
  }
  to_convention(mesh);
  return swaps;
}

inline std::vector<std::uint64_t> numbers(const TopologyCounts& c) {
  return {c.vertices_used,
          c.triangles,
          c.edges,
          c.boundary_edges,
          c.boundary_loops,
          c.nonmanifold_edges,
          c.nonmanifold_vertices,
          c.misoriented_edges,
          c.components,
          static_cast<std::uint64_t>(c.euler)};
}

/// Sum over inner edges of the angle between the two normals, degrees.
inline double dihedral_sum(const Mesh& mesh) {
  double sum = 0;
  for (const auto& [edge, both] : edges_of(mesh))
    if (both.size() == 2)
      sum += std::acos(std::clamp(
                 dot(normal_of(mesh, mesh.triangles[both[0]]), normal_of(mesh, mesh.triangles[both[1]])), -1.0, 1.0)) *
             57.29577951308232;
  return sum;
}

/// The mesh of a shape of tests/support.
inline Mesh mesh_of(const std::string& shape, double bin_mm, double noise_mm = 0) {
  auto points = support::shape_named(shape).points(bin_mm);
  if (noise_mm > 0) points = support::with_noise(std::move(points), noise_mm, 3);
  for (Vec3& p : points) p = support::snapped(p);  // for the checker
  auto meshed = support::mesh_points(std::move(points), support::what_of(bin_mm));
  return meshed.ok() ? std::move(meshed->surface.mesh) : Mesh{};
}

}  // namespace scanmill::optimise
