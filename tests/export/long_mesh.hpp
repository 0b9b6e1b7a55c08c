// SPDX-License-Identifier: Apache-2.0
// Meshes of any length that take no memory, and a sink that counts.
#pragma once
#include <algorithm>
#include <array>
#include <cstring>
#include <span>
#include <string>
#include <vector>

#include "export/mesh_writers.hpp"
#include "export/writers.hpp"

namespace scanmill::exporting {

/// Counts bytes and keeps the first and last few.
class CountingSink final : public ByteSink {
 public:
  const std::string& name() const override { return name_; }
  using ByteSink::write;
  Result<void> write(std::span<const char> bytes) override {
    if (head.size() < 4096) head.append(bytes.data(), std::min<std::size_t>(bytes.size(), 4096 - head.size()));
    tail.append(bytes.data() + (bytes.size() > 256 ? bytes.size() - 256 : 0), std::min<std::size_t>(bytes.size(), 256));
    if (tail.size() > 256) tail.erase(0, tail.size() - 256);
    count += bytes.size();
    return {};
  }
  Result<void> commit() override { return {}; }
  std::uint64_t count = 0;
  std::string head, tail;

 private:
  std::string name_ = "counted";
};

/// A wall of bricks, any number of triangles long: triangle t joins vertices t / 2 and those beside it, so rows follow
/// from the number. All corners lie in a box of 64 mm, which keeps the text of every number short.
class LongMesh final : public MeshStream {
 public:
  LongMesh(std::uint64_t triangles, std::uint64_t vertices, bool with_patches = false)
      : triangles_(triangles), vertices_(vertices), with_patches_(with_patches) {}
  std::uint64_t vertices() const override { return vertices_; }
  std::uint64_t triangles() const override { return triangles_; }
  Vec3 offset() const override { return {}; }
  Bounds bounds() const override {
    Bounds box;
    for (std::uint64_t v = 0; v < std::min<std::uint64_t>(vertices_, 1 << 18); ++v) box.add(place(v));
    return box;
  }
  std::vector<std::uint32_t> patch_ids() const override {
    return with_patches_ ? std::vector<std::uint32_t>{0, 7} : std::vector<std::uint32_t>{};
  }
  bool is_closed() const override { return false; }
  static Vec3 place(std::uint64_t v) {
    return {static_cast<double>(v & 63), static_cast<double>(v >> 6 & 63), static_cast<double>(v >> 12 & 63)};
  }
  Result<void> each_vertices(OnVertices visit) const override {
    std::vector<Vec3> block(4096);
    for (std::uint64_t v = 0; v < vertices_; v += block.size()) {
      const std::size_t count = static_cast<std::size_t>(std::min<std::uint64_t>(block.size(), vertices_ - v));
      for (std::size_t i = 0; i < count; ++i) block[i] = place(v + i);
      TRY(visit(std::span(block).first(count)));
    }
    return {};
  }
  Result<void> each_triangles(Corners corners, OnTriangles visit) const override {
    std::vector<Triangle> rows(4096);
    std::vector<std::array<Vec3, 3>> places(4096);
    std::vector<std::uint32_t> patch(4096);
    for (std::uint64_t t = 0; t < triangles_; t += rows.size()) {
      const std::size_t count = static_cast<std::size_t>(std::min<std::uint64_t>(rows.size(), triangles_ - t));
      for (std::size_t i = 0; i < count; ++i) {
        const std::uint64_t first = (t + i) / 2 % (vertices_ - 2);
        for (std::uint32_t c = 0; c < 3; ++c) rows[i][c] = static_cast<std::uint32_t>(first + c);
        if (corners == Corners::Yes) places[i] = {place(rows[i][0]), place(rows[i][1]), place(rows[i][2])};
        patch[i] = (t + i) < triangles_ / 2 ? 0 : 7;
      }
      TRY(visit(
          {std::span(rows).first(count),
           corners == Corners::Yes ? std::span<const std::array<Vec3, 3>>(places).first(count)
                                   : std::span<const std::array<Vec3, 3>>(),
           with_patches_ ? std::span<const std::uint32_t>(patch).first(count) : std::span<const std::uint32_t>()}));
    }
    return {};
  }

 private:
  std::uint64_t triangles_, vertices_;
  bool with_patches_;
};

}  // namespace scanmill::exporting
