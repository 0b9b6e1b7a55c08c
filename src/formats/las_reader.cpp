// SPDX-License-Identifier: Apache-2.0
// LAS 1.0 to 1.4, as in the ASPRS specification: a header, records nobody here needs, then points of fixed size whose
// first twelve bytes are whole numbers with a scale and an offset from the header.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "base/text.hpp"
#include "formats/cursor.hpp"
#include "formats/readers.hpp"

namespace scanmill::formats {
namespace {

constexpr std::uint64_t kRunRows = 65536;
constexpr std::size_t kShortest = 227, kWithCounts = 375;
constexpr std::uint64_t kPointBytes[] = {20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67};  // by point format

template <class T>
T value_at(const std::string& bytes, std::size_t at) {
  T value;
  std::memcpy(&value, bytes.data() + at, sizeof(T));
  return value;
}

struct LasHeader {
  int minor = 0, point_format = 0;
  std::uint64_t points = 0, stride = 0, data_offset = 0;
  Vec3 scale, offset;
  std::vector<std::string> notes;
};

/// LAS 1.0 may put DD CC between its records and its points, and count it to neither.
Result<void> skip_mark(const ByteSource& source, LasHeader& las) {
  if (las.minor != 0 || source.size() < las.data_offset + 2) return {};
  std::array<char, 2> mark{};
  TRY(read_exactly(source, las.data_offset, mark));
  if (mark == std::array<char, 2>{'\xdd', '\xcc'} && source.size() - las.data_offset - 2 == las.points * las.stride)
    las.data_offset += 2;
  return {};
}

Result<void> take_counts(const ByteSource& source, const std::string& bytes, LasHeader& las) {
  const std::uint64_t legacy = value_at<std::uint32_t>(bytes, 107);
  las.points = legacy;
  if (las.minor < 4) return {};
  las.points = value_at<std::uint64_t>(bytes, 247);
  if (las.points == 0 && legacy > 0) {
    las.points = legacy;
    las.notes.push_back("the 64-bit point count is 0; the old field with " + std::to_string(legacy) + " is taken");
  } else if (legacy != 0 && legacy != las.points) {
    return fail(Code::BadInput,
                "the header declares " + std::to_string(las.points) + " points in its 64-bit field and " +
                    std::to_string(legacy) + " in the old one",
                byte_place(source.name(), 107));
  }
  return {};
}

Result<void> take_numbers(const ByteSource& source, const std::string& bytes, LasHeader& las) {
  las.scale = {value_at<double>(bytes, 131), value_at<double>(bytes, 139), value_at<double>(bytes, 147)};
  las.offset = {value_at<double>(bytes, 155), value_at<double>(bytes, 163), value_at<double>(bytes, 171)};
  const bool flat = las.scale.x == 0 || las.scale.y == 0 || las.scale.z == 0;
  if (flat || !is_finite(las.scale) || !is_finite(las.offset))
    return fail(Code::BadInput,
                "the scale factors are " + number_text(las.scale.x) + " " + number_text(las.scale.y) + " " +
                    number_text(las.scale.z) + " and the offsets " + number_text(las.offset.x) + " " +
                    number_text(las.offset.y) + " " + number_text(las.offset.z) +
                    "; wanted finite numbers, scales not 0",
                byte_place(source.name(), 131));
  return {};
}

Result<LasHeader> read_header(const ByteSource& source) {
  std::string bytes(std::min<std::uint64_t>(source.size(), kWithCounts), '\0');
  TRY(read_exactly(source, 0, std::span<char>(bytes.data(), bytes.size())));
  if (bytes.substr(0, 4) != "LASF")
    return fail(Code::BadInput, "found " + quoted(bytes.substr(0, 4)) + ", wanted LASF", byte_place(source.name(), 0));
  if (bytes.size() < kShortest)
    return fail(Code::BadInput,
                "the file has " + std::to_string(bytes.size()) + " bytes, a LAS header takes 227; it was cut",
                byte_place(source.name(), bytes.size()));
  LasHeader las;
  const int major = static_cast<unsigned char>(bytes[24]);
  las.minor = static_cast<unsigned char>(bytes[25]);
  if (major != 1 || las.minor > 4)
    return fail(Code::Unsupported,
                "found LAS version " + std::to_string(major) + "." + std::to_string(las.minor) + ", wanted 1.0 to 1.4",
                byte_place(source.name(), 24));
  const std::size_t header_size = value_at<std::uint16_t>(bytes, 94), wanted = las.minor == 4 ? kWithCounts : kShortest;
  if (header_size < wanted || bytes.size() < wanted)
    return fail(Code::BadInput,
                "the header has " + std::to_string(std::min(header_size, bytes.size())) + " bytes, LAS 1." +
                    std::to_string(las.minor) + " takes " + std::to_string(wanted),
                byte_place(source.name(), 94));
  las.data_offset = value_at<std::uint32_t>(bytes, 96);
  las.point_format = static_cast<unsigned char>(bytes[104]);
  if (las.point_format & 0xc0)
    return fail(Code::Unsupported,
                "the points are compressed (LAZ), which is not read by this version; convert the file to LAS",
                byte_place(source.name(), 104));
  if (las.point_format > 10)
    return fail(Code::Unsupported, "found point format " + std::to_string(las.point_format) + ", wanted 0 to 10",
                byte_place(source.name(), 104));
  las.stride = value_at<std::uint16_t>(bytes, 105);
  const std::uint64_t least = kPointBytes[las.point_format];
  if (las.stride < least)
    return fail(Code::BadInput,
                "the header declares points of " + std::to_string(las.stride) + " bytes, point format " +
                    std::to_string(las.point_format) + " takes " + std::to_string(least),
                byte_place(source.name(), 105));
  TRY(take_counts(source, bytes, las));
  TRY(take_numbers(source, bytes, las));
  if (las.data_offset < header_size || (las.data_offset > source.size() && las.points > 0))
    return fail(Code::BadInput,
                "the header says that points begin at byte " + std::to_string(las.data_offset) +
                    ", wanted a place behind the header's " + std::to_string(header_size) + " bytes and within the " +
                    std::to_string(source.size()) + " bytes of the file",
                byte_place(source.name(), 96));
  const std::uint64_t held = las.data_offset > source.size() ? 0 : (source.size() - las.data_offset) / las.stride;
  if (las.points > held)
    return fail(Code::BadInput,
                "the header declares " + std::to_string(las.points) + " points, the file ends after " +
                    std::to_string(held) + "; it was cut or its header is wrong",
                byte_place(source.name(), source.size()));
  TRY(skip_mark(source, las));
  return las;
}

class LasReader final : public ViewReader {
 public:
  LasReader(std::shared_ptr<const ByteSource> source, LasHeader las)
      : source_(std::move(source)), las_(std::move(las)) {
    header_.format = "las 1." + std::to_string(las_.minor) + " format " + std::to_string(las_.point_format);
    header_.row_meaning = RowMeaning::PointFromZero;
    header_.rows = las_.points;
    header_.notes = std::move(las_.notes);
  }

  const ViewHeader& header() const override { return header_; }
  std::size_t block_count() const override { return static_cast<std::size_t>((las_.points + kRunRows - 1) / kRunRows); }

  Result<void> read_block(std::size_t number, PointBlock& out) const override {
    const std::uint64_t row = number * kRunRows;
    const auto count = static_cast<std::size_t>(std::min(kRunRows, las_.points - row));
    thread_local std::vector<char> bytes;
    bytes.resize(count * las_.stride);
    TRY(read_exactly(*source_, las_.data_offset + row * las_.stride, bytes));
    out.points_read = count;
    out.not_finite = out.sensor_invalid = 0;
    out.positions.resize(count);
    out.rows.resize(count);
    std::size_t kept = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const char* const record = bytes.data() + i * las_.stride;
      if (is_withheld(record)) {
        ++out.sensor_invalid;
        continue;
      }
      std::array<std::int32_t, 3> grid;
      std::memcpy(grid.data(), record, 12);
      const Vec3 p{grid[0] * las_.scale.x + las_.offset.x, grid[1] * las_.scale.y + las_.offset.y,
                   grid[2] * las_.scale.z + las_.offset.z};
      if (!is_finite(p)) {
        ++out.not_finite;
        continue;
      }
      out.positions[kept] = p;
      out.rows[kept++] = row + i;
    }
    out.positions.resize(kept);
    out.rows.resize(kept);
    return {};
  }

 private:
  /// "Should not be included in processing": bit 7 of the classification byte since 1.1, bit 2 of the flags from point
  /// format 6 on; both are byte 15.
  bool is_withheld(const char* record) const {
    const auto flags = static_cast<unsigned char>(record[15]);
    return las_.point_format >= 6 ? (flags & 4) != 0 : las_.minor >= 1 && (flags & 128) != 0;
  }

  std::shared_ptr<const ByteSource> source_;
  LasHeader las_;
  ViewHeader header_;
};

}  // namespace

Result<std::unique_ptr<ViewReader>> open_las(std::shared_ptr<const ByteSource> source) {
  if (source->size() == 0)
    return fail(Code::BadInput, "the file is empty (0 bytes), wanted a LAS header", source->name());
  TRY_ASSIGN(LasHeader las, read_header(*source));
  return std::unique_ptr<ViewReader>(std::make_unique<LasReader>(std::move(source), std::move(las)));
}

}  // namespace scanmill::formats
