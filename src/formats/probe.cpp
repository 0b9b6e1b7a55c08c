// SPDX-License-Identifier: Apache-2.0
#include "formats/probe.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <optional>
#include <vector>

#include "formats/cursor.hpp"
#include "formats/decimal.hpp"
#include "formats/mesh_builder.hpp"
#include "formats/ply_header.hpp"
#include "formats/text_columns.hpp"

namespace scanmill::formats {
namespace {

constexpr std::size_t kLook = 1 << 16;

struct Magic {
  std::string_view bytes;
  const char* format;
};
using namespace std::string_view_literals;
constexpr Magic kMagics[] = {
    {"ASTM-E57"sv, "E57"}, {"\xff\xd8\xff"sv, "JPEG"},  {"II*\0"sv, "TIFF"},    {"MM\0*"sv, "TIFF"},
    {"\x89HDF"sv, "HDF5"}, {"PK\x03\x04"sv, "ZIP/3MF"}, {"\x1f\x8b"sv, "gzip"}, {"ISO-10303-21"sv, "STEP"},
    {"glTF"sv, "glTF"},    {"# vtk DataFile"sv, "VTK"}, {"<?xml"sv, "XML"},
};

struct Suffix {
  std::string_view suffix;
  const char* format;
};
constexpr Suffix kUnsupported[] = {
    {"laz", "LAZ"},     {"e57", "E57"},   {"stl", "STL"},   {"obj", "OBJ"},   {"off", "OFF"},
    {"3mf", "ZIP/3MF"}, {"gltf", "glTF"}, {"glb", "glTF"},  {"vtk", "VTK"},   {"vtp", "VTK"},
    {"igs", "IGES"},    {"iges", "IGES"}, {"stp", "STEP"},  {"step", "STEP"}, {"dxf", "DXF"},
    {"fls", "FARO"},    {"rdb", "RIEGL"}, {"rxp", "RIEGL"}, {"zfs", "Z+F"},
};
constexpr std::string_view kPoints[] = {"ply",  "xyz",    "asc",  "txt", "csv", "pwn", "pts",
                                        "xyzn", "xyzrgb", "xyzi", "dat", "pcd", "las", "ptx"};
constexpr std::size_t kLasPointFormat = 104;  // its byte; the two highest bits mean LAZ

bool is_text(std::string_view bytes) { return bytes.find('\0') == std::string_view::npos; }

/// Lines of four numbers whose every fourth is 0 0 0 1; lines of three whole numbers before each matrix (trajectory
/// logs).
bool holds_pose_matrices(std::string_view text, bool complete) {
  std::size_t rows = 0;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = text.find('\n', at);
    if (end == std::string_view::npos && !complete) break;
    const std::string_view line = text.substr(at, std::min(end, text.size()) - at);
    at = end == std::string_view::npos ? text.size() : end + 1;
    if (is_comment_or_blank(line)) continue;
    const auto words = columns_of(line);
    if (words.size() == 3 && rows % 4 == 0 && line.find_first_of(".eEnN") == std::string_view::npos) continue;
    if (words.size() != 4) return false;
    std::array<double, 4> row{};
    for (std::size_t i = 0; i < 4; ++i)
      if (parse_decimal(words[i].data(), words[i].data() + words[i].size(), row[i]) !=
              words[i].data() + words[i].size() ||
          words[i].empty())
        return false;
    if (++rows % 4 == 0 && row != std::array<double, 4>{0, 0, 0, 1}) return false;
  }
  return rows >= 4 && (rows % 4 == 0 || !complete);
}

/// Formats whose files are read as meshes, though not as clouds.
bool is_mesh_format(std::string_view format) { return format == "STL" || format == "OBJ" || format == "OFF"; }

/// The ten lines that begin a PTX scan: two counts, four times three numbers, four times four.
bool looks_like_ptx(std::string_view text) {
  std::size_t row = 0;
  for (std::size_t at = 0; at < text.size() && row < 10;) {
    const std::size_t end = text.find('\n', at);
    if (end == std::string_view::npos) return false;
    const std::string_view line = text.substr(at, end - at);
    at = end + 1;
    if (is_comment_or_blank(line)) continue;
    const auto words = columns_of(line);
    if (words.size() != (row < 2 ? 1u : row < 6 ? 3u : 4u)) return false;
    for (const std::string_view word : words) {
      double value = 0;
      if (word.empty() || parse_decimal(word.data(), word.data() + word.size(), value) != word.data() + word.size())
        return false;
    }
    ++row;
  }
  return row == 10;
}

bool looks_like_pcd(std::string_view text) {
  if (text.starts_with("# .PCD") || text.starts_with(".PCD")) return true;
  return text.starts_with("VERSION ") && text.find("\nFIELDS ") != std::string_view::npos;
}

/// Formats with readers of their own, by content.
std::optional<Probe> probe_content(std::string_view bytes) {
  if (bytes.starts_with("LASF")) {
    const bool packed = bytes.size() > kLasPointFormat && (bytes[kLasPointFormat] & 0xc0) != 0;
    return packed ? Probe{FileKind::Unsupported, "LAZ", false} : Probe{FileKind::Las, "las", false};
  }
  if (bytes.starts_with("\x89PNG")) return Probe{FileKind::DepthMap, "PNG", false};
  if (looks_like_pcd(bytes)) return Probe{FileKind::Pcd, "pcd", false};
  if (bytes.starts_with("scanmill_fringes:") || bytes.find("\nscanmill_fringes:") != std::string_view::npos)
    return Probe{FileKind::Fringes, "fringes", false};
  return std::nullopt;
}

/// The same by suffix, where the content does not tell.
std::optional<Probe> probe_suffix(std::string_view suffix) {
  if (suffix == "ply") return Probe{FileKind::Ply, "ply", false};
  if (suffix == "pcd") return Probe{FileKind::Pcd, "pcd", false};
  if (suffix == "las") return Probe{FileKind::Las, "las", false};
  if (suffix == "ptx") return Probe{FileKind::Ptx, "ptx", false};
  if (suffix == "png") return Probe{FileKind::DepthMap, "PNG", false};
  if (suffix == "fringes") return Probe{FileKind::Fringes, "fringes", false};
  return std::nullopt;
}

Probe probe_ply(const ByteSource& source) {
  Probe result{FileKind::Ply, "ply", false};
  const auto header = read_ply_header(source);
  if (!header.ok()) return result;
  for (const PlyElement& element : header->elements)
    result.has_faces |= (element.name == "face" || element.name == "tristrips") && element.count > 0;
  return result;
}

}  // namespace

std::string suffix_of(std::string_view path) {
  const auto slash = path.rfind('/');
  if (slash != std::string_view::npos) path.remove_prefix(slash + 1);
  const auto dot = path.rfind('.');
  if (dot == std::string_view::npos || dot == 0) return {};
  std::string suffix(path.substr(dot + 1));
  for (char& c : suffix)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return suffix;
}

bool is_point_suffix(std::string_view suffix) {
  return std::find(std::begin(kPoints), std::end(kPoints), suffix) != std::end(kPoints);
}

bool is_unsupported_suffix(std::string_view suffix) {
  return std::any_of(std::begin(kUnsupported), std::end(kUnsupported),
                     [&](const Suffix& row) { return row.suffix == suffix; });
}

bool is_packed_suffix(std::string_view suffix) {
  static constexpr std::string_view kPacked[] = {"gz", "tgz", "zip", "tar", "bz2", "xz", "zst", "7z", "rar"};
  return std::find(std::begin(kPacked), std::end(kPacked), suffix) != std::end(kPacked);
}

bool is_depth_map(const ByteSource& source) {
  constexpr std::size_t kDepthAt = 24, kColourAt = 25;  // of the first chunk, IHDR
  std::array<char, kColourAt + 1> bytes{};
  if (source.size() < bytes.size() || !read_exactly(source, 0, bytes).ok()) return false;
  return std::string_view(bytes.data(), 4) == "\x89PNG" && bytes[kDepthAt] == 16 && bytes[kColourAt] == 0;
}

Result<Probe> probe(const ByteSource& source) {
  std::string bytes(std::min<std::uint64_t>(source.size(), kLook), '\0');
  TRY(read_exactly(source, 0, std::span<char>(bytes.data(), bytes.size())));
  const std::string suffix = suffix_of(source.name());
  if (looks_like_ply(bytes)) return probe_ply(source);
  if (auto found = probe_content(bytes)) return *found;
  for (const Magic& magic : kMagics)
    if (bytes.compare(0, magic.bytes.size(), magic.bytes) == 0)
      return Probe{FileKind::Unsupported, magic.format, false};
  if (auto found = probe_suffix(suffix)) return *found;
  for (const Suffix& row : kUnsupported)
    if (row.suffix == suffix) return Probe{FileKind::Unsupported, row.format, is_mesh_format(row.format)};
  if (is_binary_stl(bytes, source.size())) return Probe{FileKind::Unsupported, "STL", true};
  if (!bytes.empty() && !is_text(bytes))
    return Probe{suffix != "txt" && suffix != "dat" && is_point_suffix(suffix) ? FileKind::Text : FileKind::Other,
                 "text", false};
  const bool complete = bytes.size() == source.size();
  if (looks_like_ptx(bytes)) return Probe{FileKind::Ptx, "ptx", false};
  if (suffix == "pts") return Probe{FileKind::Pts, "pts", false};
  if (holds_pose_matrices(bytes, complete)) return Probe{FileKind::PoseMatrices, "4x4 matrices", false};
  const auto start = judge_start(bytes, complete, source.name());
  // Prose called .txt or .csv is no scan that failed; the suffixes below say "points" by themselves.
  const bool may_be_prose = suffix == "txt" || suffix == "csv" || suffix == "dat" || !is_point_suffix(suffix);
  const bool empty = bytes.empty() && is_point_suffix(suffix);
  const bool holds_numbers = start.ok() ? start->has_data || start->declared_points
                                        : start.error().message.find("three numbers") == std::string::npos;
  if (empty || !may_be_prose || holds_numbers) return Probe{FileKind::Text, "text", false};
  return Probe{FileKind::Other, "", false};
}

}  // namespace scanmill::formats
