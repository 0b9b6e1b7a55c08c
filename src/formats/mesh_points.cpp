// SPDX-License-Identifier: Apache-2.0
// The vertices of a mesh file as a cloud: the whole mesh is read, since its corners say which points there are.
#include <algorithm>
#include <numeric>

#include "formats/mesh_reader.hpp"
#include "formats/readers.hpp"

namespace scanmill::formats {
namespace {

class MeshPoints final : public ViewReader {
 public:
  explicit MeshPoints(MeshFile mesh) : positions_(std::move(mesh.positions)) {
    if (mesh.offset)
      for (Vec3& p : positions_) p = p + *mesh.offset;
    header_.format = mesh.format;
    header_.rows = positions_.size();
    header_.has_faces = true;
    header_.notes = std::move(mesh.notes);
  }
  const ViewHeader& header() const override { return header_; }
  std::size_t block_count() const override { return (positions_.size() + kBlock - 1) / kBlock; }
  Result<void> read_block(std::size_t number, PointBlock& out) const override {
    const std::size_t begin = number * kBlock, end = std::min(positions_.size(), begin + kBlock);
    out.positions.assign(positions_.begin() + static_cast<std::ptrdiff_t>(begin),
                         positions_.begin() + static_cast<std::ptrdiff_t>(end));
    out.rows.resize(end - begin);
    std::iota(out.rows.begin(), out.rows.end(), begin);
    out.points_read = end - begin;
    out.not_finite = out.sensor_invalid = 0;
    return {};
  }

 private:
  static constexpr std::size_t kBlock = 16384;
  std::vector<Vec3> positions_;
  ViewHeader header_;
};

}  // namespace

Result<std::unique_ptr<ViewReader>> open_mesh_points(std::shared_ptr<const ByteSource> source) {
  const std::string name = source->name();
  TRY_ASSIGN(MeshFile mesh, read_mesh(std::move(source)));
  if (mesh.positions.empty()) return fail(Code::BadInput, "the mesh has no vertex, so there are no points", name);
  return std::unique_ptr<ViewReader>(std::make_unique<MeshPoints>(std::move(mesh)));
}

}  // namespace scanmill::formats
