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

Result<void> check(const Mesh& mesh, const PlyMeshOptions& options, const std::string& name) {
  if (mesh.positions.size() > 0x7fffffffull)
    return fail(Code::Unsupported,
                "the mesh has " + grouped(mesh.positions.size()) +
                    " vertices, but the PLY numbers them in 31 bits; choose a larger bin",
                name);
  auto fits = [](std::size_t length, std::size_t wanted) { return length == 0 || length == wanted; };
  if (!fits(options.error.size(), mesh.positions.size()) || !fits(options.error_rms.size(), mesh.positions.size()) ||
      !fits(mesh.patch.size(), mesh.triangles.size()))
    return fail(Code::Internal, "errors or patch ids do not fit the numbers of vertices and triangles", name);
  return {};
}

std::string header_of(const Mesh& mesh, const PlyMeshOptions& options) {
  std::string text = "ply\nformat binary_little_endian 1.0\ncomment scanmill mesh, units mm\n";
  if (!(mesh.offset == Vec3{}))
    text += "comment offset_mm " + number_text(mesh.offset.x) + " " + number_text(mesh.offset.y) + " " +
            number_text(mesh.offset.z) + "\n";
  for (const std::string& comment : options.comments) text += comment_line(comment);
  text += "element vertex " + std::to_string(mesh.positions.size()) + "\n";
  for (const char* axis : {"x", "y", "z"})
    text += std::string("property ") + (options.double_positions ? "double " : "float ") + axis + "\n";
  if (!options.error.empty()) text += "property float error\n";
  if (!options.error_rms.empty()) text += "property float error_rms\n";
  text += "element face " + std::to_string(mesh.triangles.size()) + "\nproperty list uchar int vertex_indices\n";
  if (!mesh.patch.empty()) text += "property uint patch\n";
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
  TRY(check(mesh, options, sink.name()));
  const std::string header = header_of(mesh, options);
  TRY(sink.write(std::string_view(header)));
  Records out(sink);
  char*& at = out.at();
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    const Vec3& p = mesh.positions[v];
    for (const double c : {p.x, p.y, p.z})
      at = options.double_positions ? put(at, without_minus_zero(c))
                                    : put(at, without_minus_zero(static_cast<float>(c)));
    if (!options.error.empty()) at = put(at, without_minus_zero(options.error[v]));
    if (!options.error_rms.empty()) at = put(at, without_minus_zero(options.error_rms[v]));
    TRY(out.flush_when_full());
  }
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    at = put(at, std::uint8_t{3});
    for (const std::uint32_t corner : mesh.triangles[t]) at = put(at, static_cast<std::int32_t>(corner));
    if (!mesh.patch.empty()) at = put(at, mesh.patch[t]);
    TRY(out.flush_when_full());
  }
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
