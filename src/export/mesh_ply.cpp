// SPDX-License-Identifier: Apache-2.0
#include "base/text.hpp"
#include "export/comparing_sink.hpp"
#include "export/little_endian.hpp"
#include "export/mesh_writers.hpp"

namespace scanmill::exporting {
namespace {

constexpr std::size_t kBufferBytes = 1 << 18;

/// A comment is one line of printable text, whatever it was made from.
std::string comment_line(std::string text) {
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
  return "comment " + text + "\n";
}

Result<void> check(const MeshStream& mesh, const PlyMeshOptions& options, const std::string& name) {
  if (mesh.vertices() > 0x7fffffffull)
    return fail(Code::Unsupported,
                "the mesh has " + grouped(mesh.vertices()) +
                    " vertices, but the PLY numbers them in 31 bits; choose a larger bin",
                name);
  auto fits = [&](std::size_t length) { return length == 0 || length == mesh.vertices(); };
  if (!fits(options.error.size()) || !fits(options.error_rms.size()))
    return fail(Code::Internal, "errors do not fit the number of vertices", name);
  return {};
}

std::string header_of(const MeshStream& mesh, bool has_patches, const PlyMeshOptions& options) {
  std::string text = "ply\nformat binary_little_endian 1.0\ncomment scanmill mesh, units mm\n";
  if (const Vec3 o = mesh.offset(); !(o == Vec3{}))
    text += "comment offset_mm " + number_text(o.x) + " " + number_text(o.y) + " " + number_text(o.z) + "\n";
  for (const std::string& comment : options.comments) text += comment_line(comment);
  text += "element vertex " + std::to_string(mesh.vertices()) + "\n";
  for (const char* axis : {"x", "y", "z"})
    text += std::string("property ") + (options.double_positions ? "double " : "float ") + axis + "\n";
  if (!options.error.empty()) text += "property float error\n";
  if (!options.error_rms.empty()) text += "property float error_rms\n";
  text += "element face " + std::to_string(mesh.triangles()) + "\nproperty list uchar int vertex_indices\n";
  if (has_patches) text += "property uint patch\n";
  return text + "end_header\n";
}

/// Records of at most 64 bytes on their way to a sink.
class Records {
 public:
  explicit Records(ByteSink& sink) : sink_(sink), buffer_(kBufferBytes + 64), at_(buffer_.data()) {}
  char*& at() { return at_; }
  Result<void> flush_when_full() { return at_ >= buffer_.data() + kBufferBytes ? flush() : Result<void>{}; }
  Result<void> flush() {
    const auto size = static_cast<std::size_t>(at_ - buffer_.data());
    at_ = buffer_.data();
    return size == 0 ? Result<void>{} : sink_.write(std::span<const char>(buffer_.data(), size));
  }

 private:
  ByteSink& sink_;
  std::vector<char> buffer_;
  char* at_;
};

}  // namespace

Result<void> write_ply_mesh(const Mesh& mesh, const PlyMeshOptions& options, ByteSink& sink) {
  TRY(check_patches(mesh, sink.name()));
  return stream_ply_mesh(MeshBlocks(mesh), options, sink);
}

Result<void> stream_ply_mesh(const MeshStream& mesh, const PlyMeshOptions& options, ByteSink& sink) {
  TRY(check(mesh, options, sink.name()));
  const std::string header = header_of(mesh, !mesh.patch_ids().empty(), options);
  TRY(sink.write(std::string_view(header)));
  Records out(sink);
  char*& at = out.at();
  std::size_t v = 0;
  TRY(mesh.each_vertices([&](std::span<const Vec3> positions) -> Result<void> {
    for (const Vec3& p : positions) {
      for (const double c : {p.x, p.y, p.z})
        at = options.double_positions ? put(at, without_minus_zero(c))
                                      : put(at, without_minus_zero(static_cast<float>(c)));
      if (!options.error.empty()) at = put(at, without_minus_zero(options.error[v]));
      if (!options.error_rms.empty()) at = put(at, without_minus_zero(options.error_rms[v]));
      ++v;
      TRY(out.flush_when_full());
    }
    return {};
  }));
  TRY(mesh.each_triangles(Corners::No, [&](const TriangleBlock& block) -> Result<void> {
    for (std::size_t t = 0; t < block.rows.size(); ++t) {
      at = put(at, std::uint8_t{3});
      for (const std::uint32_t corner : block.rows[t]) at = put(at, static_cast<std::int32_t>(corner));
      if (!block.patch.empty()) at = put(at, block.patch[t]);
      TRY(out.flush_when_full());
    }
    return {};
  }));
  return out.flush();
}

Result<void> compare_ply_mesh(const Mesh& mesh, const PlyMeshOptions& options, const ByteSource& source) {
  ComparingSink sink(source);
  TRY(write_ply_mesh(mesh, options, sink));
  return sink.commit();
}

bool fits_float32(std::span<const Vec3> positions) {
  for (const Vec3& p : positions)
    for (const double c : {p.x, p.y, p.z})
      if (static_cast<double>(static_cast<float>(c)) != c) return false;
  return true;
}

}  // namespace scanmill::exporting
