// SPDX-License-Identifier: Apache-2.0
#include "formats/mesh_builder.hpp"

#include <algorithm>

#include "base/text.hpp"
#include "formats/line_words.hpp"

namespace scanmill::formats {
namespace {

constexpr std::size_t kMaxNotes = 20;
constexpr std::uint64_t kMaxVertices = 0xfffffffeull;

}  // namespace

std::string Place::text(const std::string& file) const {
  return is_line ? line_place(file, number) : byte_place(file, number);
}

Result<void> MeshBuilder::add_vertex(Vec3 position) {
  if (mesh.positions.size() >= kMaxVertices)
    return fail(Code::Unsupported, "the file has more than 4,294,967,294 vertices; split it", name_);
  not_finite_ += !is_finite(position);
  mesh.positions.push_back(position);
  return {};
}

void MeshBuilder::add_polygon(std::span<const std::uint64_t> corners, Place place) {
  if (corners.size() < 3) {
    ++mesh.faces_left_out;
    return;
  }
  for (const std::uint64_t corner : corners) {
    if (any_corner_ && corner <= greatest_) continue;
    any_corner_ = true;
    greatest_ = corner;
    greatest_place_ = place;
  }
  mesh.polygons_split += corners.size() > 3;
  for (std::size_t i = 2; i < corners.size(); ++i) {
    // Corners beyond 32 bits are found out in finish(); until then their low bits stand in.
    const Triangle t{static_cast<std::uint32_t>(corners[0]), static_cast<std::uint32_t>(corners[i - 1]),
                     static_cast<std::uint32_t>(corners[i])};
    mesh.repeated_corners += t[0] == t[1] || t[1] == t[2] || t[2] == t[0];
    mesh.triangles.push_back(t);
  }
}

void MeshBuilder::add_comment(std::string_view text) {
  while (!text.empty() && (text.back() == '\r' || text.back() == ' ')) text.remove_suffix(1);
  if (!mesh.offset) mesh.offset = offset_in(text);
  if (!text.empty() && mesh.comments.size() < kMaxComments) mesh.comments.emplace_back(text);
}

void MeshBuilder::note(std::string text) {
  if (mesh.notes.size() < kMaxNotes && std::find(mesh.notes.begin(), mesh.notes.end(), text) == mesh.notes.end())
    mesh.notes.push_back(std::move(text));
}

void MeshBuilder::skipped(const std::string& property) {
  if (mesh.properties.size() < kMaxNotes &&
      std::find(mesh.properties.begin(), mesh.properties.end(), property) == mesh.properties.end())
    mesh.properties.push_back(property);
}

Result<MeshFile> MeshBuilder::finish() {
  if (any_corner_ && greatest_ >= vertex_count())
    return fail(Code::BadInput,
                "a face names vertex " + grouped(greatest_) + " (counted from 0), the file has " +
                    grouped(vertex_count()) + " vertices; it was cut or its indices are wrong",
                greatest_place_.text(name_));
  if (not_finite_ > 0) TRY(drop_not_finite());
  if (mesh.polygons_split > 0)
    note(grouped(mesh.polygons_split) + " faces of more than three corners were split into triangles");
  if (mesh.faces_left_out > 0) note(grouped(mesh.faces_left_out) + " faces of fewer than three corners were left out");
  if (mesh.repeated_corners > 0)
    note(grouped(mesh.repeated_corners) + " triangles name a vertex twice; they have no area");
  for (const std::string& property : mesh.properties) note("not read: " + property);
  return std::move(mesh);
}

Result<void> MeshBuilder::drop_not_finite() {
  constexpr std::uint32_t kDropped = 0xffffffffu;
  std::vector<std::uint32_t> row(mesh.positions.size(), kDropped);
  std::uint32_t kept = 0;
  for (std::size_t v = 0; v < row.size(); ++v) {
    if (!is_finite(mesh.positions[v])) continue;
    for (auto* column : {&mesh.error, &mesh.error_rms})
      if (!column->empty()) (*column)[kept] = (*column)[v];
    mesh.positions[kept] = mesh.positions[v];
    row[v] = kept++;
  }
  for (Triangle& t : mesh.triangles)
    for (std::uint32_t& corner : t) {
      if (row[corner] == kDropped)
        return fail(Code::BadInput,
                    "vertex " + grouped(corner) +
                        " (counted from 0) is NaN or infinite and a face uses it; remove the "
                        "face or measure the vertex",
                    name_);
      corner = row[corner];
    }
  note(grouped(row.size() - kept) + " vertices that no face uses are NaN or infinite and were dropped");
  mesh.positions.resize(kept);
  for (auto* column : {&mesh.error, &mesh.error_rms})
    if (!column->empty()) column->resize(kept);
  return {};
}

std::optional<Vec3> offset_in(std::string_view text) {
  LineWords words(text);
  for (std::string_view word = words.next(); !word.empty(); word = words.next()) {
    if (!is_word(word, "offset_mm")) continue;
    Vec3 offset;
    if (words.number(offset.x) && words.number(offset.y) && words.number(offset.z) && is_finite(offset)) return offset;
    return std::nullopt;
  }
  return std::nullopt;
}

}  // namespace scanmill::formats
