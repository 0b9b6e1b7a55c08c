// SPDX-License-Identifier: Apache-2.0
// PCD bodies: lines, rows of fixed size, or one LZF stream that holds the fields one behind the other.
#include <algorithm>
#include <cstring>
#include <numeric>

#include "base/text.hpp"
#include "formats/cursor.hpp"
#include "formats/decimal.hpp"
#include "formats/lzf.hpp"
#include "formats/pcd_header.hpp"
#include "formats/ply_decode.hpp"
#include "formats/readers.hpp"

namespace scanmill::formats {
namespace {

constexpr std::uint64_t kRunRows = 65536;
constexpr std::uint64_t kRunBytes = 4 << 20;

struct Run {
  std::uint64_t offset = 0, row = 0, line = 0;
};

/// Where blocks begin, the end as last entry; and the tokens of a compressed body.
struct Body {
  std::vector<Run> runs;
  LzfStream lzf;
};

class PcdReader final : public ViewReader {
 public:
  PcdReader(std::shared_ptr<const ByteSource> source, PcdHeader pcd, Body body)
      : source_(std::move(source)), pcd_(std::move(pcd)), body_(std::move(body)) {
    static constexpr const char* kNames[] = {"pcd ascii", "pcd binary", "pcd binary_compressed"};
    header_.format = kNames[static_cast<std::size_t>(pcd_.data)];
    header_.row_meaning = RowMeaning::PointFromZero;
    header_.rows = pcd_.points;
    header_.has_grid = pcd_.is_grid;
    header_.notes = std::move(pcd_.notes);
    header_.view_point.eye = pcd_.eye;
    for (std::size_t axis = 0; axis < 3; ++axis) xyz_[axis] = {pcd_.xyz_type[axis], pcd_.fields[pcd_.xyz[axis]].offset};
  }

  const ViewHeader& header() const override { return header_; }
  std::size_t block_count() const override { return body_.runs.size() - 1; }

  Result<void> read_block(std::size_t number, PointBlock& out) const override {
    const Run& run = body_.runs[number];
    const auto count = static_cast<std::size_t>(body_.runs[number + 1].row - run.row);
    out.points_read = count;
    out.not_finite = out.sensor_invalid = 0;
    out.positions.resize(count);
    out.rows.resize(count);
    std::iota(out.rows.begin(), out.rows.end(), run.row);
    if (pcd_.data == PcdData::Ascii)
      TRY(read_lines(run, body_.runs[number + 1].offset, out.positions));
    else if (pcd_.data == PcdData::Binary)
      TRY(read_rows(run, out.positions));
    else
      TRY(read_columns(run, out.positions));
    out.not_finite = drop_not_finite(out.positions, out.rows);
    return {};
  }

 private:
  Result<void> read_rows(const Run& run, std::vector<Vec3>& positions) const {
    thread_local std::vector<char> bytes;
    bytes.resize(positions.size() * pcd_.stride);
    TRY(read_exactly(*source_, run.offset, bytes));
    decode_positions(bytes.data(), pcd_.stride, xyz_, false, positions.size(), positions.data());
    return {};
  }

  Result<void> read_columns(const Run& run, std::vector<Vec3>& positions) const {
    thread_local std::vector<char> bytes;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const PlyType type = pcd_.xyz_type[axis];
      const std::size_t size = size_of(type);
      bytes.resize(positions.size() * size);
      // A column begins behind the columns of the fields before it.
      const std::uint64_t from = pcd_.points * xyz_[axis].offset + run.row * size;
      TRY(read_lzf(*source_, body_.lzf, from, bytes));
      for (std::size_t i = 0; i < positions.size(); ++i) {
        const double value = load_value(type, false, bytes.data() + i * size);
        (axis == 0 ? positions[i].x : axis == 1 ? positions[i].y : positions[i].z) = value;
      }
    }
    return {};
  }

  Result<void> read_lines(const Run& run, std::uint64_t end, std::vector<Vec3>& positions) const {
    thread_local std::vector<char> bytes;
    bytes.resize(static_cast<std::size_t>(end - run.offset));
    TRY(read_exactly(*source_, run.offset, bytes));
    std::string_view rest(bytes.data(), bytes.size());
    std::uint64_t line_number = run.line;
    for (std::size_t i = 0; i < positions.size(); ++line_number) {
      if (rest.empty())
        return fail(Code::IoFailed, "the file changed while it was read", line_place(source_->name(), line_number));
      const auto stop = std::min(rest.find('\n'), rest.size());
      const std::string_view line = rest.substr(0, stop);
      rest.remove_prefix(std::min(stop + 1, rest.size()));
      if (line.find_first_not_of(" \t\r") == std::string_view::npos) continue;
      TRY_ASSIGN(positions[i], read_line(line, line_number));
      ++i;
    }
    return {};
  }

  /// Words are parted by blanks alone: a comma is a mistake of the program that wrote the file.
  Result<Vec3> read_line(std::string_view line, std::uint64_t number) const {
    std::uint64_t word = 0;
    std::array<double, 3> p{};
    int good = 0;
    for (std::size_t at = line.find_first_not_of(" \t\r"); at != std::string_view::npos; ++word) {
      const std::size_t end = std::min(line.find_first_of(" \t\r", at), line.size());
      for (std::size_t axis = 0; axis < 3; ++axis)
        if (pcd_.fields[pcd_.xyz[axis]].word == word)
          good += parse_decimal(line.data() + at, line.data() + end, p[axis]) == line.data() + end;
      at = line.find_first_not_of(" \t\r", end);
    }
    if (good == 3 && word == pcd_.words) return Vec3{p[0], p[1], p[2]};
    return fail(Code::BadInput,
                "found " + quoted(line) + ", wanted " + std::to_string(pcd_.words) + " values parted by blanks" +
                    (word == pcd_.words ? " with numbers for x, y and z" : ", found " + std::to_string(word)) +
                    (line.find(',') != std::string_view::npos ? "; write decimal points, and no commas" : ""),
                line_place(source_->name(), number));
  }

  std::shared_ptr<const ByteSource> source_;
  PcdHeader pcd_;
  Body body_;
  Coordinate xyz_[3];
  ViewHeader header_;
};

std::string behind_note(const ByteSource& source, std::uint64_t end) {
  return std::to_string(source.size() - end) + " bytes behind the last point (from byte " + std::to_string(end) +
         ") were not read";
}

/// Zeros up to the end of a page or so are how the Point Cloud Library writes; anything else is worth a note.
Result<void> look_behind(const ByteSource& source, std::uint64_t end, PcdHeader& header) {
  std::string rest(std::min<std::uint64_t>(source.size() - end, 1 << 16), '\0');
  TRY(read_exactly(source, end, std::span<char>(rest.data(), rest.size())));
  if (end + rest.size() < source.size() || rest.find_first_not_of('\0') != std::string::npos)
    header.notes.push_back(behind_note(source, end));
  return {};
}

/// WIDTH x HEIGHT and POINTS tell two numbers; the file must say which is true.
Result<void> settle_points(const ByteSource& source, PcdHeader& header, bool points_fit) {
  if (!header.cells) return {};
  const std::string found =
      "WIDTH x HEIGHT is " + std::to_string(*header.cells) + ", POINTS is " + std::to_string(header.points);
  if (!points_fit) return fail(Code::BadInput, found + "; correct the header", source.name());
  header.notes.push_back(found + "; the file holds as many as POINTS says");
  return {};
}

Result<Body> find_lines(const ByteSource& source, PcdHeader& header) {
  Body body;
  Cursor cursor(source, header.data_offset);
  std::uint64_t row = 0, line = header.data_line, end = header.data_offset;
  bool more = false;
  for (; !cursor.at_end(); ++line) {
    const std::uint64_t at = cursor.offset();
    std::string_view text;
    if (!cursor.line_at_hand(text)) {
      TRY_ASSIGN(text, cursor.line());
    }
    if (text.size() > kMaxLine)
      return fail(Code::BadInput, "the line is longer than 1 MiB", line_place(source.name(), line));
    if (text.find_first_not_of(" \t\r") == std::string_view::npos) continue;
    if (row == header.points) {
      header.notes.push_back(behind_note(source, at));
      more = true;
      break;
    }
    if (body.runs.empty() || row - body.runs.back().row >= kRunRows || at - body.runs.back().offset >= kRunBytes)
      body.runs.push_back({at, row, line});
    ++row;
    end = cursor.offset();
  }
  if (row < header.points)
    return fail(Code::BadInput,
                "the header declares " + std::to_string(header.points) + " points, the file ends after " +
                    std::to_string(row) + "; it was cut or its header is wrong",
                line_place(source.name(), line));
  TRY(settle_points(source, header, !more));
  body.runs.push_back({end, row, line});
  return body;
}

Result<Body> find_rows(const ByteSource& source, PcdHeader& header) {
  Body body;
  const std::uint64_t left = source.size() - header.data_offset;
  if (header.points > left / header.stride)
    return fail(Code::BadInput,
                "the header declares " + std::to_string(header.points) + " points of " + std::to_string(header.stride) +
                    " bytes, the file ends after " + std::to_string(left / header.stride) +
                    "; it was cut or its header is wrong",
                byte_place(source.name(), source.size()));
  const std::uint64_t end = header.data_offset + header.points * header.stride;
  TRY(settle_points(source, header, end == source.size()));
  TRY(look_behind(source, end, header));
  const std::uint64_t step = std::clamp<std::uint64_t>((16 << 20) / header.stride, 1, kRunRows);
  for (std::uint64_t row = 0; row < header.points; row += step)
    body.runs.push_back({header.data_offset + row * header.stride, row, 0});
  body.runs.push_back({end, header.points, 0});
  return body;
}

Result<Body> find_columns(const ByteSource& source, PcdHeader& header) {
  Body body;
  const std::string place = byte_place(source.name(), header.data_offset);
  if (source.size() - header.data_offset < 8)
    return fail(Code::BadInput, "the file ends before the sizes of its compressed data; it was cut", place);
  std::array<std::uint32_t, 2> sizes{};
  TRY(read_exactly(source, header.data_offset, std::span<char>(reinterpret_cast<char*>(sizes.data()), 8)));
  const std::uint64_t compressed = sizes[0], size = sizes[1], begin = header.data_offset + 8;
  if (header.points > (1ull << 32) / header.stride || size != header.points * header.stride)
    return fail(Code::BadInput,
                "the compressed data declares " + std::to_string(size) + " decoded bytes, the header " +
                    std::to_string(header.points) + " points of " + std::to_string(header.stride) + " bytes",
                place);
  if (compressed > source.size() - begin)
    return fail(Code::BadInput,
                "the compressed data declares " + std::to_string(compressed) + " bytes, the file has " +
                    std::to_string(source.size() - begin) + " more; it was cut",
                place);
  TRY(settle_points(source, header, true));
  TRY_ASSIGN(body.lzf, index_lzf(source, begin, compressed, size));
  TRY(look_behind(source, body.lzf.end, header));
  for (std::uint64_t row = 0; row < header.points; row += kRunRows) body.runs.push_back({0, row, 0});
  body.runs.push_back({0, header.points, 0});
  return body;
}

}  // namespace

Result<std::unique_ptr<ViewReader>> open_pcd(std::shared_ptr<const ByteSource> source) {
  if (source->size() == 0)
    return fail(Code::BadInput, "the file is empty (0 bytes), wanted a PCD header", source->name());
  TRY_ASSIGN(PcdHeader header, read_pcd_header(*source));
  TRY_ASSIGN(Body body, header.data == PcdData::Ascii    ? find_lines(*source, header)
                        : header.data == PcdData::Binary ? find_rows(*source, header)
                                                         : find_columns(*source, header));
  return std::unique_ptr<ViewReader>(
      std::make_unique<PcdReader>(std::move(source), std::move(header), std::move(body)));
}

}  // namespace scanmill::formats
