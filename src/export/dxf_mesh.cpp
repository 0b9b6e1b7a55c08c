// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <numeric>

#include "base/text.hpp"
#include "export/comparing_sink.hpp"
#include "export/dxf.hpp"

namespace scanmill::exporting {
namespace {

constexpr std::string_view kStyles[] = {"faces", "polyface"};
constexpr std::size_t kPolyfaceVertices = 32'767;
constexpr std::uint32_t kNone = 0xffffffffu;

std::uint32_t patch_at(const Mesh& mesh, std::size_t t) { return mesh.patch.empty() ? 0 : mesh.patch[t]; }
std::string layer_of(std::uint32_t patch) { return "PATCH_" + std::to_string(patch); }

/// Triangles of one patch, cut where the vertices would exceed what the format numbers.
class Polyfaces {
 public:
  Polyfaces(const Mesh& mesh, DxfWriter& out) : mesh_(mesh), out_(out), row_of_(mesh.positions.size(), kNone) {}
  Result<void> add(std::uint32_t patch, const Triangle& t) {
    std::size_t fresh = 0;
    for (const std::uint32_t corner : t) fresh += row_of_[corner] == kNone;
    if (!triangles_.empty() && (patch != patch_ || rows_.size() + fresh > kPolyfaceVertices)) TRY(flush());
    patch_ = patch;
    Triangle local;
    for (std::size_t c = 0; c < 3; ++c) {
      std::uint32_t& row = row_of_[t[c]];
      if (row == kNone) {
        row = static_cast<std::uint32_t>(rows_.size());
        rows_.push_back(t[c]);
      }
      local[c] = row;
    }
    triangles_.push_back(local);
    return {};
  }
  Result<void> flush() {
    std::vector<Vec3> vertices;
    vertices.reserve(rows_.size());
    for (const std::uint32_t row : rows_) {
      vertices.push_back(mesh_.positions[row]);
      row_of_[row] = kNone;
    }
    rows_.clear();
    TRY(out_.polyface(layer_of(patch_), vertices, triangles_));
    triangles_.clear();
    return {};
  }

 private:
  const Mesh& mesh_;
  DxfWriter& out_;
  std::vector<std::uint32_t> row_of_, rows_;
  std::vector<Triangle> triangles_;
  std::uint32_t patch_ = 0;
};

std::vector<DxfLayer> layers_of(std::vector<std::uint32_t> ids) {
  if (ids.empty()) ids.assign(1, 0);
  std::vector<DxfLayer> layers;
  for (const std::uint32_t id : ids) layers.push_back({layer_of(id), dxf_colour(id)});
  return layers;
}

Result<void> begin(const MeshStream& mesh, DxfWriter& out, const std::string& name) {
  if (mesh.triangles() == 0) return fail(Code::BadInput, "the mesh has no triangle to write", name);
  std::vector<std::string> comments{"scanmill mesh, units mm"};
  if (const Vec3 o = mesh.offset(); !(o == Vec3{}))
    comments.push_back("offset_mm " + number_text(o.x) + " " + number_text(o.y) + " " + number_text(o.z));
  return out.begin(mesh.bounds(), layers_of(mesh.patch_ids()), comments);
}

}  // namespace

std::span<const std::string_view> dxf_style_words() { return kStyles; }

Result<void> write_dxf(const Mesh& mesh, DxfStyle style, ByteSink& sink) {
  TRY(check_patches(mesh, sink.name()));
  const MeshBlocks blocks(mesh);
  if (style == DxfStyle::Faces) return stream_dxf_faces(blocks, sink);
  DxfWriter out(sink);
  TRY(begin(blocks, out, sink.name()));
  std::vector<std::size_t> order(mesh.triangles.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return patch_at(mesh, a) < patch_at(mesh, b); });
  Polyfaces faces(mesh, out);
  for (const std::size_t t : order) TRY(faces.add(patch_at(mesh, t), mesh.triangles[t]));
  TRY(faces.flush());
  return out.end();
}

Result<void> stream_dxf_faces(const MeshStream& mesh, ByteSink& sink) {
  DxfWriter out(sink);
  TRY(begin(mesh, out, sink.name()));
  TRY(mesh.each_triangles(Corners::Yes, [&](const TriangleBlock& block) -> Result<void> {
    for (std::size_t t = 0; t < block.corners.size(); ++t) {
      const auto& corners = block.corners[t];
      TRY(out.face(layer_of(block.patch.empty() ? 0 : block.patch[t]), corners[0], corners[1], corners[2]));
    }
    return {};
  }));
  return out.end();
}

Result<void> compare_dxf(const Mesh& mesh, DxfStyle style, const ByteSource& source) {
  ComparingSink sink(source);
  TRY(write_dxf(mesh, style, sink));
  return sink.commit();
}

}  // namespace scanmill::exporting
