// SPDX-License-Identifier: Apache-2.0
#include "export/range_maps.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/text.hpp"
#include "export/grey_png.hpp"
#include "export/little_endian.hpp"
#include "export/text_buffer.hpp"
#include "export/writers.hpp"

namespace scanmill::exporting {
namespace {

constexpr std::string_view kWords[] = {"ply", "xyz", "ptx", "pcd", "png"};

float plain(double value) { return without_minus_zero(static_cast<float>(value)); }

std::string one_line(const std::string& comment) {
  std::string line = "# " + comment;
  for (char& c : line)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
  return line + "\n";
}

void add_point(TextBuffer& out, Vec3 p) {
  out.number(plain(p.x)).text(" ").number(plain(p.y)).text(" ").number(plain(p.z));
}

Result<void> write_xyz(const RangeGrid& grid, std::span<const std::string> comments, ByteSink& sink) {
  for (const std::string& comment : comments) TRY(sink.write(std::string_view(one_line(comment))));
  TextBuffer out(sink);
  for (const Vec3& p : grid.points) {
    if (!is_finite(p)) continue;
    add_point(out, p);
    out.text("\n");
    TRY(out.flush_when_full());
  }
  return out.flush();
}

Result<void> write_ptx(const RangeGrid& grid, ByteSink& sink) {
  TextBuffer out(sink);
  out.number(grid.width).text("\n").number(grid.height).text("\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n");
  out.text("1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n");
  for (std::int64_t column = 0; column < grid.width; ++column)
    for (std::int64_t row = 0; row < grid.height; ++row) {
      const Vec3 p = grid.points[static_cast<std::size_t>(row * grid.width + column)];
      if (is_finite(p)) {
        add_point(out, p);
        out.text(" 0.5\n");
      } else {
        out.text("0 0 0 0.5\n");
      }
      TRY(out.flush_when_full());
    }
  return out.flush();
}

Result<void> write_pcd(const RangeGrid& grid, std::span<const std::string> comments, ByteSink& sink) {
  std::string head = "# .PCD v0.7 - Point Cloud Data file format\n";
  for (const std::string& comment : comments) head += one_line(comment);
  const std::string width = std::to_string(grid.width), height = std::to_string(grid.height);
  head += "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH " + width + "\nHEIGHT " + height +
          "\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " + std::to_string(grid.points.size()) + "\nDATA binary\n";
  TRY(sink.write(std::string_view(head)));
  std::vector<char> bytes(grid.points.size() * 3 * sizeof(float));
  char* at = bytes.data();
  for (const Vec3& p : grid.points)
    for (const double value : {p.x, p.y, p.z}) at = put(at, plain(value));
  return sink.write(std::span<const char>(bytes));
}

Result<void> write_depths(const RangeGrid& grid, ByteSink& sink) {
  std::vector<std::uint16_t> pixels(grid.points.size());
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    if (!is_finite(grid.points[i])) continue;
    const double value = std::floor(grid.points[i].z * grid.depth_scale + 0.5);
    if (!(value >= 1 && value <= 65535))
      return fail(Code::BadParameter,
                  "a depth of " + number_text(grid.points[i].z) + " times depth_scale " +
                      number_text(grid.depth_scale) + " does not fit into 16 bits; choose another depth_scale",
                  sink.name());
    pixels[i] = static_cast<std::uint16_t>(value);
  }
  return write_grey_png(pixels, static_cast<std::uint32_t>(grid.width), 16, sink);
}

}  // namespace

std::span<const std::string_view> range_format_words() { return kWords; }

std::optional<RangeFormat> range_format_of(std::string_view word) {
  const auto found = std::find(std::begin(kWords), std::end(kWords), word);
  if (found == std::end(kWords)) return {};
  return static_cast<RangeFormat>(found - std::begin(kWords));
}

Result<void> write_range_map(RangeFormat format, const RangeGrid& grid, std::span<const std::string> comments,
                             ByteSink& sink) {
  switch (format) {
    case RangeFormat::Ply:
      return write_view_ply(grid.points, comments, sink);
    case RangeFormat::Xyz:
      return write_xyz(grid, comments, sink);
    case RangeFormat::Ptx:
      return write_ptx(grid, sink);
    case RangeFormat::Pcd:
      return write_pcd(grid, comments, sink);
    case RangeFormat::Png:
      break;
  }
  return write_depths(grid, sink);
}

}  // namespace scanmill::exporting
