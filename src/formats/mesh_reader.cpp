// SPDX-License-Identifier: Apache-2.0
#include "formats/mesh_reader.hpp"

#include <algorithm>
#include <cstring>
#include <numeric>

#include "formats/line_words.hpp"
#include "formats/mesh_builder.hpp"
#include "formats/ply_header.hpp"
#include "formats/probe.hpp"

namespace scanmill::formats {
namespace {

constexpr std::size_t kLook = 1 << 14;

/// The first line with a word on it that is no comment.
std::string_view first_line(std::string_view text) {
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    const std::string_view line = text.substr(at, end - at);
    const std::string_view word = LineWords(line).next();
    if (!word.empty() && word[0] != '#') return line;
    at = end + 1;
  }
  return {};
}

/// Some line gives a vertex and some line a face.
bool looks_like_obj(std::string_view text) {
  bool vertex = false, face = false;
  for (std::size_t at = 0; at < text.size() && !(vertex && face);) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    LineWords words(text.substr(at, end - at));
    const std::string_view word = words.next();
    double value = 0;
    vertex |= word == "v" && words.number(value) && words.number(value) && words.number(value);
    face |= word == "f" && !words.next().empty() && !words.next().empty() && !words.next().empty();
    at = end + 1;
  }
  return vertex && face;
}

}  // namespace

Result<MeshKind> mesh_kind_of(const ByteSource& source) {
  std::string bytes(static_cast<std::size_t>(std::min<std::uint64_t>(source.size(), kLook)), '\0');
  TRY(read_exactly(source, 0, std::span<char>(bytes.data(), bytes.size())));
  if (looks_like_ply(bytes)) return MeshKind::Ply;
  if (is_binary_stl(bytes, source.size())) return MeshKind::Stl;
  const std::string suffix = suffix_of(source.name());
  if (bytes.find('\0') == std::string::npos) {
    const std::string_view line = first_line(bytes);
    const std::string_view word = LineWords(line).next();
    if (is_off_keyword(word)) return MeshKind::Off;
    if (is_word(word, "solid") && suffix != "obj" && suffix != "off" && suffix != "ply") return MeshKind::Stl;
    if (suffix != "stl" && suffix != "off" && suffix != "ply" && looks_like_obj(bytes)) return MeshKind::Obj;
  }
  if (suffix == "stl") return MeshKind::Stl;
  if (suffix == "obj") return MeshKind::Obj;
  if (suffix == "off") return MeshKind::Off;
  if (suffix == "ply") return MeshKind::Ply;
  return MeshKind::None;
}

Result<MeshFile> read_mesh(std::shared_ptr<const ByteSource> source) {
  if (source->size() == 0) return fail(Code::BadInput, "the file is empty (0 bytes), wanted a mesh", source->name());
  TRY_ASSIGN(const MeshKind kind, mesh_kind_of(*source));
  switch (kind) {
    case MeshKind::Stl:
      return read_stl_mesh(*source);
    case MeshKind::Obj:
      return read_obj_mesh(*source);
    case MeshKind::Off:
      return read_off_mesh(*source);
    case MeshKind::Ply:
      return read_ply_mesh(*source);
    case MeshKind::None:
      break;
  }
  return fail(Code::BadInput, "the file is no mesh in a format that is read; wanted STL, OBJ, OFF or PLY with faces",
              source->name());
}

Mesh mesh_of(const MeshFile& file) {
  const std::size_t n = file.triangles.size();
  std::vector<Triangle> turned(n);
  for (std::size_t i = 0; i < n; ++i) {
    const Triangle& t = file.triangles[i];
    const auto first = static_cast<std::size_t>(std::min_element(t.begin(), t.end()) - t.begin());
    turned[i] = {t[first], t[(first + 1) % 3], t[(first + 2) % 3]};
  }
  std::vector<std::size_t> order(n);
  std::iota(order.begin(), order.end(), std::size_t{0});
  if (!std::is_sorted(turned.begin(), turned.end()))
    std::sort(order.begin(), order.end(),
              [&](std::size_t a, std::size_t b) { return turned[a] != turned[b] ? turned[a] < turned[b] : a < b; });
  Mesh mesh;
  mesh.positions = file.positions;
  mesh.offset = file.offset.value_or(Vec3{});
  mesh.triangles.reserve(n);
  mesh.patch.reserve(n);
  for (const std::size_t i : order) {
    mesh.triangles.push_back(turned[i]);
    mesh.patch.push_back(file.patch.empty() ? 0 : file.patch[i]);
  }
  return mesh;
}

}  // namespace scanmill::formats
