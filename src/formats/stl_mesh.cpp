// SPDX-License-Identifier: Apache-2.0
// STL, binary and ASCII. Many programs write binary files whose header begins with "solid", so the size decides first;
// only then is the text looked at.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "base/digest.hpp"
#include "base/text.hpp"
#include "formats/line_words.hpp"
#include "formats/mesh_builder.hpp"

namespace scanmill::formats {
namespace {

constexpr std::size_t kHeaderBytes = 80, kPreambleBytes = 84, kRecordBytes = 50, kRecordsAtOnce = 8192;

/// Corners with exactly equal coordinates get one row, in order of first appearance. Open addressing over the float32
/// bits; 4 bytes per slot beside the positions themselves.
class ExactJoin {
 public:
  explicit ExactJoin(MeshBuilder& builder) : builder_(builder), slots_(1 << 10, kFree) {}

  Result<std::uint64_t> row_of(std::array<float, 3> corner) {
    for (float& c : corner)
      if (c == 0) c = 0;  // -0 too
    if (2 * (builder_.vertex_count() + 1) > slots_.size()) grow();
    std::size_t at = hash_of(corner) & (slots_.size() - 1);
    for (; slots_[at] != kFree; at = (at + 1) & (slots_.size() - 1))
      if (bits_at(slots_[at]) == corner) return std::uint64_t{slots_[at]};
    const std::uint64_t row = builder_.vertex_count();
    TRY(builder_.add_vertex({double{corner[0]}, double{corner[1]}, double{corner[2]}}));
    slots_[at] = static_cast<std::uint32_t>(row);
    return row;
  }

 private:
  static constexpr std::uint32_t kFree = 0xffffffffu;

  static std::uint64_t hash_of(const std::array<float, 3>& corner) {
    std::array<std::uint32_t, 3> bits{};
    std::memcpy(bits.data(), corner.data(), sizeof bits);
    return mix64((std::uint64_t{bits[0]} << 32 | bits[1]) ^ mix64(bits[2]));
  }
  std::array<float, 3> bits_at(std::uint32_t row) const {
    const Vec3& p = builder_.mesh.positions[row];
    return {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)};
  }
  void grow() {
    slots_.assign(2 * slots_.size(), kFree);
    for (std::uint32_t row = 0; row < builder_.vertex_count(); ++row) {
      std::size_t at = hash_of(bits_at(row)) & (slots_.size() - 1);
      while (slots_[at] != kFree) at = (at + 1) & (slots_.size() - 1);
      slots_[at] = row;
    }
  }

  MeshBuilder& builder_;
  std::vector<std::uint32_t> slots_;
};

Result<void> add_facet(ExactJoin& join, MeshBuilder& builder, const std::array<std::array<float, 3>, 3>& corners,
                       Place place, const std::string& name) {
  std::array<std::uint64_t, 3> rows{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (const float c : corners[i])
      if (!std::isfinite(c))
        return fail(Code::BadInput,
                    "found " + number_text(double{c}) + " as a coordinate of a facet, wanted a number float32 holds",
                    place.text(name));
    TRY_ASSIGN(rows[i], join.row_of(corners[i]));
  }
  builder.add_polygon(rows, place);
  return {};
}

class BinaryStl {
 public:
  explicit BinaryStl(const ByteSource& source) : source_(source), builder_(source.name()), join_(builder_) {}

  Result<MeshFile> read() {
    TRY(read_preamble());
    builder_.mesh.format = "stl binary";
    builder_.mesh.coordinates = CoordinateForm::Float32;
    builder_.mesh.triangles.reserve(count_);  // the bytes are there
    std::vector<char> buffer(kRecordBytes * std::min<std::size_t>(kRecordsAtOnce, count_));
    std::uint64_t attributes = 0;
    for (std::uint64_t first = 0; first < count_; first += kRecordsAtOnce) {
      const auto records = static_cast<std::size_t>(std::min<std::uint64_t>(kRecordsAtOnce, count_ - first));
      const std::uint64_t offset = kPreambleBytes + kRecordBytes * first;
      TRY(read_exactly(source_, offset, std::span<char>(buffer.data(), kRecordBytes * records)));
      for (std::size_t i = 0; i < records; ++i) {
        const char* record = buffer.data() + kRecordBytes * i;
        std::array<std::array<float, 3>, 3> corners{};
        std::memcpy(corners.data(), record + 12, 36);
        attributes += record[48] != 0 || record[49] != 0;
        TRY(add_facet(join_, builder_, corners, {false, offset + kRecordBytes * i}, source_.name()));
      }
    }
    if (attributes > 0) builder_.skipped("the attribute bytes of " + grouped(attributes) + " facets (colours)");
    return builder_.finish();
  }

 private:
  Result<void> read_preamble() {
    if (source_.size() < kPreambleBytes)
      return fail(Code::BadInput,
                  "the file ends after " + grouped(source_.size()) + " bytes; a binary STL begins with a header of 84",
                  byte_place(source_.name(), source_.size()));
    std::array<char, kPreambleBytes> bytes{};
    TRY(read_exactly(source_, 0, bytes));
    std::memcpy(&count_, bytes.data() + kHeaderBytes, sizeof count_);
    const std::uint64_t wanted = kPreambleBytes + std::uint64_t{kRecordBytes} * count_;
    if (wanted > source_.size() || (count_ == 0 && source_.size() >= kPreambleBytes + kRecordBytes))
      return fail(Code::BadInput,
                  "the header announces " + grouped(count_) + " facets, which take " + grouped(wanted) +
                      " bytes, but the file has " + grouped(source_.size()) + "; it was cut or its count is wrong",
                  byte_place(source_.name(), std::min(wanted, source_.size())));
    if (wanted < source_.size())
      builder_.note(grouped(source_.size() - wanted) + " bytes behind the last facet (from byte " +
                    std::to_string(wanted) + ") were not read");
    std::string title(bytes.data(), kHeaderBytes);
    for (char& c : title)
      if (static_cast<unsigned char>(c) < 0x20 || static_cast<unsigned char>(c) > 0x7e) c = ' ';
    builder_.add_comment(title);
    return {};
  }

  const ByteSource& source_;
  MeshBuilder builder_;
  ExactJoin join_;
  std::uint32_t count_ = 0;
};

/// Words in any arrangement of lines, keywords in any case; behind `solid` and `endsolid` the rest of the line is a
/// name.
class AsciiStl {
 public:
  explicit AsciiStl(const ByteSource& source)
      : source_(source), lines_(source), builder_(source.name()), join_(builder_) {}

  Result<MeshFile> read() {
    builder_.mesh.format = "stl ascii";
    for (;;) {
      TRY_ASSIGN(const std::string_view word, next_word());
      if (word.empty()) break;
      if (!is_word(word, "solid")) return wrong(word, "solid");
      builder_.add_comment(words_.rest());
      words_ = LineWords({});
      TRY(read_solid());
    }
    if (solids_ > 1) builder_.note(grouped(solids_) + " solids were joined to one mesh");
    return builder_.finish();
  }

 private:
  Error wrong(std::string_view found, const char* wanted) const {
    const std::string place = line_place(source_.name(), lines_.number());
    if (found.empty())
      return fail(Code::BadInput, "the file ends where " + std::string(wanted) + " is wanted; it was cut", place);
    return fail(Code::BadInput, "found " + quoted(found) + ", wanted " + wanted, place);
  }

  /// Empty at the end of the file.
  Result<std::string_view> next_word() {
    for (;;) {
      if (const std::string_view word = words_.next(); !word.empty()) return word;
      if (lines_.at_end()) return std::string_view{};
      TRY_ASSIGN(const std::string_view line, lines_.next());
      words_ = LineWords(line);
    }
  }

  Result<void> expect(const char* keyword) {
    TRY_ASSIGN(const std::string_view word, next_word());
    if (!is_word(word, keyword)) return wrong(word, keyword);
    return {};
  }

  Result<float> number() {
    double value = 0;
    if (!words_.number(value)) {
      TRY_ASSIGN(const std::string_view word, next_word());
      const char* end = word.data() + word.size();
      if (word.empty() || parse_decimal(word.data(), end, value) != end) return wrong(word, "a number");
    }
    return static_cast<float>(value);
  }

  Result<void> read_solid() {
    ++solids_;
    for (;;) {
      TRY_ASSIGN(const std::string_view word, next_word());
      if (is_word(word, "endsolid")) {
        words_ = LineWords({});
        return {};
      }
      if (!is_word(word, "facet")) return wrong(word, "facet or endsolid");
      TRY(read_facet());
    }
  }

  Result<void> read_facet() {
    const std::uint64_t line = lines_.number();
    TRY(expect("normal"));
    for (int i = 0; i < 3; ++i) {  // not used: the corners say it
      TRY_ASSIGN([[maybe_unused]] const float component, number());
    }
    TRY(expect("outer"));
    TRY(expect("loop"));
    std::array<std::array<float, 3>, 3> corners{};
    for (auto& corner : corners) {
      TRY(expect("vertex"));
      for (float& c : corner) {
        TRY_ASSIGN(c, number());
      }
    }
    TRY(expect("endloop"));
    TRY(expect("endfacet"));
    return add_facet(join_, builder_, corners, {true, line}, source_.name());
  }

  const ByteSource& source_;
  NumberedLines lines_;
  LineWords words_{{}};
  MeshBuilder builder_;
  ExactJoin join_;
  std::uint64_t solids_ = 0;
};

}  // namespace

bool is_binary_stl(std::string_view first_bytes, std::uint64_t size) {
  if (first_bytes.size() < kPreambleBytes) return false;
  std::uint32_t count = 0;
  std::memcpy(&count, first_bytes.data() + kHeaderBytes, sizeof count);
  return size == kPreambleBytes + std::uint64_t{kRecordBytes} * count;
}

Result<MeshFile> read_stl_mesh(const ByteSource& source) {
  std::string bytes(static_cast<std::size_t>(std::min<std::uint64_t>(source.size(), 1024)), '\0');
  TRY(read_exactly(source, 0, std::span<char>(bytes.data(), bytes.size())));
  const std::size_t begin = std::min(bytes.find_first_not_of(" \t\r\n"), bytes.size());
  const bool is_text = bytes.find('\0') == std::string::npos && is_word(bytes.substr(begin, 5), "solid");
  if (!is_binary_stl(bytes, source.size()) && is_text) return AsciiStl(source).read();
  return BinaryStl(source).read();
}

}  // namespace scanmill::formats
