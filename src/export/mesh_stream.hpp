// SPDX-License-Identifier: Apache-2.0
// A mesh as its writers see it: vertices and triangles in blocks, in order, as often as asked; so that a file may be
// larger than memory. Counts are 64 bits wide; rows of vertices have 32, as everywhere.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "base/context.hpp"
#include "base/result.hpp"
#include "mesh/mesh.hpp"

namespace scanmill::exporting {

struct TriangleBlock {
  std::span<const Triangle> rows;
  std::span<const std::array<Vec3, 3>> corners;  // their positions, as Mesh holds them; empty when not asked for
  std::span<const std::uint32_t> patch;          // empty for a mesh without patches
};

enum class Corners : bool { No, Yes };

class MeshStream {
 public:
  using OnVertices = FunctionRef<Result<void>(std::span<const Vec3>)>;
  using OnTriangles = FunctionRef<Result<void>(const TriangleBlock&)>;
  virtual ~MeshStream() = default;
  virtual std::uint64_t vertices() const = 0;
  virtual std::uint64_t triangles() const = 0;
  /// To be added to positions for the global frame, mm.
  virtual Vec3 offset() const = 0;
  /// Of the positions.
  virtual Bounds bounds() const = 0;
  /// Ascending, each once; empty for a mesh without patches.
  virtual std::vector<std::uint32_t> patch_ids() const = 0;
  /// Every edge has two triangles, oppositely directed.
  virtual bool is_closed() const = 0;
  /// Blocks of any size, ascending rows. errors  those of `visit`, which end it
  virtual Result<void> each_vertices(OnVertices visit) const = 0;
  virtual Result<void> each_triangles(Corners corners, OnTriangles visit) const = 0;
};

/// A mesh in memory; `order`: triangles in another order than the mesh's, all of them, or empty.
class MeshBlocks final : public MeshStream {
 public:
  explicit MeshBlocks(const Mesh& mesh, std::span<const std::size_t> order = {}) : mesh_(mesh), order_(order) {}
  std::uint64_t vertices() const override { return mesh_.positions.size(); }
  std::uint64_t triangles() const override { return mesh_.triangles.size(); }
  Vec3 offset() const override { return mesh_.offset; }
  Bounds bounds() const override;
  std::vector<std::uint32_t> patch_ids() const override;
  bool is_closed() const override;
  Result<void> each_vertices(OnVertices visit) const override;
  Result<void> each_triangles(Corners corners, OnTriangles visit) const override;

 private:
  const Mesh& mesh_;
  std::span<const std::size_t> order_;
};

/// errors  Internal when a mesh has patch ids for some of its triangles only
Result<void> check_patches(const Mesh& mesh, const std::string& name);

}  // namespace scanmill::exporting
