// SPDX-License-Identifier: Apache-2.0
// Small meshes to look at, and loops of any number of threads.
#pragma once
#include <vector>

#include "base/random.hpp"
#include "render/render.hpp"

namespace scanmill::render {

struct Workers {
  explicit Workers(int threads = 1) : loop(threads) {}
  ChunkLoop loop;
  CancelFlag cancel;
  Context context() const { return {loop, cancel}; }
};

/// Box from the origin to `size`, outward; patch = face 0..5; without the last `missing` triangles (the top is last).
inline Mesh box_mesh(Vec3 size, std::size_t missing = 0) {
  Mesh mesh;
  for (int x = 0; x < 2; ++x)
    for (int y = 0; y < 2; ++y)
      for (int z = 0; z < 2; ++z) mesh.positions.push_back({x * size.x, y * size.y, z * size.z});
  const std::uint32_t faces[6][4] = {{0, 1, 3, 2}, {4, 6, 7, 5}, {0, 4, 5, 1},
                                     {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 5, 7, 3}};
  for (std::uint32_t f = 0; f < 6; ++f)
    for (std::size_t k = 1; k < 3; ++k) {
      if (mesh.triangles.size() + missing >= 12) continue;
      mesh.triangles.push_back({faces[f][0], faces[f][k], faces[f][k + 1]});
      mesh.patch.push_back(f);
    }
  return mesh;
}

/// n x n vertices over [0, n-1]^2 with bumps, normals up; patches of four columns.
inline Mesh bumpy_sheet(std::uint32_t n, std::uint64_t seed) {
  Mesh mesh;
  Random random(seed, 0, 0);
  for (std::uint32_t y = 0; y < n; ++y)
    for (std::uint32_t x = 0; x < n; ++x)
      mesh.positions.push_back({static_cast<double>(x), static_cast<double>(y), 2 * random.uniform()});
  for (std::uint32_t y = 0; y + 1 < n; ++y)
    for (std::uint32_t x = 0; x + 1 < n; ++x) {
      const std::uint32_t a = y * n + x, b = a + 1, c = a + n, d = c + 1;
      mesh.triangles.push_back({a, b, d});
      mesh.triangles.push_back({a, d, c});
      mesh.patch.insert(mesh.patch.end(), 2, x / 4);
    }
  return mesh;
}

inline std::size_t pixels_of(const Image& image, Rgb colour) {
  std::size_t count = 0;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) count += image.pixel(x, y) == colour;
  return count;
}

/// Pixels in which blue is clearly more than red, or less.
inline std::size_t bluish(const Image& image) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < image.rgb.size(); i += 3) count += image.rgb[i + 2] > image.rgb[i] + 12;
  return count;
}
inline std::size_t orange(const Image& image) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < image.rgb.size(); i += 3)
    count += image.rgb[i] > image.rgb[i + 2] + 60 && image.rgb[i + 1] > image.rgb[i + 2] + 30;
  return count;
}

}  // namespace scanmill::render
