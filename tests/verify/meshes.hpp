// SPDX-License-Identifier: Apache-2.0
// Meshes for tests: grids, closed shapes and soups with every fault.
#pragma once
#include <cmath>
#include <vector>

#include "base/context.hpp"
#include "base/random.hpp"
#include "mesh/mesh.hpp"

namespace scanmill::verify {

struct Workers {
  explicit Workers(int threads = 1) : loop(threads) {}
  ChunkLoop loop;
  CancelFlag cancel;
  Context context() const { return {loop, cancel}; }
};

inline Vec3 as_float(Vec3 p) {
  return {static_cast<double>(static_cast<float>(p.x)), static_cast<double>(static_cast<float>(p.y)),
          static_cast<double>(static_cast<float>(p.z))};
}

/// n x n squares of edge `step` in the plane z = height(x, y), two triangles each, facing +z.
template <class Height>
Mesh sheet(std::uint32_t n, double step, Height height) {
  Mesh mesh;
  for (std::uint32_t j = 0; j <= n; ++j)
    for (std::uint32_t i = 0; i <= n; ++i)
      mesh.positions.push_back(as_float({i * step, j * step, height(i * step, j * step)}));
  for (std::uint32_t j = 0; j < n; ++j)
    for (std::uint32_t i = 0; i < n; ++i) {
      const std::uint32_t a = j * (n + 1) + i, b = a + 1, c = a + n + 1, d = c + 1;
      mesh.triangles.push_back({a, b, d});
      mesh.triangles.push_back({a, d, c});
    }
  mesh.patch.assign(mesh.triangles.size(), 0);
  return mesh;
}
inline Mesh flat_sheet(std::uint32_t n, double step) {
  return sheet(n, step, [](double, double) { return 0.0; });
}

/// Unit cube at the origin, twelve triangles facing out.
inline Mesh cube(double edge = 1) {
  Mesh mesh;
  for (int n = 0; n < 8; ++n) mesh.positions.push_back({(n & 1) * edge, ((n >> 1) & 1) * edge, ((n >> 2) & 1) * edge});
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  mesh.patch.assign(12, 0);
  return mesh;
}

/// Triangles in any state: slivers, without area, twice the same, corners named twice, sizes over four decades.
inline Mesh soup(std::size_t triangles, std::uint64_t seed) {
  Random random(seed, triangles, 7);
  Mesh mesh;
  const auto vertices = static_cast<std::uint32_t>(triangles / 2 + 3);
  for (std::uint32_t v = 0; v < vertices; ++v) {
    const double scale = random.uniform() < 0.1 ? 10 : 1;
    Vec3 p{scale * random.gauss(), scale * random.gauss(), scale * random.gauss()};
    if (v > 0 && random.uniform() < 0.1) p = mesh.positions[v - 1];
    if (v > 1 && random.uniform() < 0.1) p = (mesh.positions[v - 1] + mesh.positions[v - 2]) * 0.5;
    if (v > 0 && random.uniform() < 0.2) p = mesh.positions[v - 1] + p * 1e-3;
    mesh.positions.push_back(as_float(p));
  }
  for (std::size_t t = 0; t < triangles; ++t) {
    const auto near = static_cast<std::uint32_t>(random.next() % vertices);
    auto other = [&] { return static_cast<std::uint32_t>((near + random.next() % 6) % vertices); };
    Triangle triangle{near, other(), other()};
    if (t > 0 && random.uniform() < 0.05) triangle = mesh.triangles[t - 1];
    mesh.triangles.push_back(triangle);
  }
  mesh.patch.assign(triangles, 0);
  return mesh;
}

}  // namespace scanmill::verify
