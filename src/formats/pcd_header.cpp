// SPDX-License-Identifier: Apache-2.0
#include "formats/pcd_header.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/text.hpp"
#include "formats/cursor.hpp"

namespace scanmill::formats {
namespace {

constexpr std::size_t kMaxHeaderLines = 1000;
constexpr std::uint64_t kMost = 1ull << 53;

using Words = std::vector<std::string_view>;

/// The values of a header line, kept until all lines are known.
struct Given {
  std::vector<std::string> values;
  std::uint64_t line = 0;  // 0: not given
};

std::optional<std::uint64_t> whole(std::string_view word) {
  std::uint64_t value = 0;
  if (word.empty()) return std::nullopt;
  for (const char c : word) {
    if (c < '0' || c > '9' || value > kMost / 10) return std::nullopt;
    value = value * 10 + static_cast<std::uint64_t>(c - '0');
  }
  return value;
}

class HeaderPass {
 public:
  explicit HeaderPass(const ByteSource& source) : source_(source), cursor_(source, 0, 1 << 16) {}

  Result<PcdHeader> run() {
    TRY(collect());
    TRY(take_fields());
    TRY(find_xyz());
    TRY(take_points());
    TRY(take_viewpoint());
    return std::move(header_);
  }

 private:
  Error wrong(const Given& given, const std::string& sentence) const {
    return fail(Code::BadInput, sentence, line_place(source_.name(), given.line));
  }

  Result<void> collect() {
    for (std::uint64_t number = 1; !cursor_.at_end(); ++number) {
      if (number > kMaxHeaderLines) break;
      TRY_ASSIGN(const std::string_view line, cursor_.line());
      const Words words = words_of(line);
      if (words.empty() || words[0].front() == '#') continue;
      std::string key(words[0]);
      for (char& c : key)
        if (c >= 'a' && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
      if (key == "COLUMNS") key = "FIELDS";
      Given* given = slot(key);
      if (given == nullptr && parse_number(words[0]))
        return fail(Code::BadInput, "found " + quoted(line) + " in the header, wanted a line such as FIELDS or DATA",
                    line_place(source_.name(), number));
      if (given == nullptr) {
        if (header_.notes.size() < 5)
          header_.notes.push_back("line " + std::to_string(number) + " of the header is unknown: " + quoted(line));
        continue;
      }
      given->line = number;
      given->values.assign(words.begin() + 1, words.end());
      if (key == "DATA") {
        header_.data_offset = cursor_.offset();
        header_.data_line = number + 1;
        return take_data();
      }
    }
    return fail(Code::BadInput, "the PCD header has no line DATA; the file was cut or is no PCD file", source_.name());
  }

  Given* slot(std::string_view key) {
    static constexpr std::string_view kKeys[] = {"VERSION", "FIELDS", "SIZE",      "TYPE",   "COUNT",
                                                 "WIDTH",   "HEIGHT", "VIEWPOINT", "POINTS", "DATA"};
    Given* const slots[] = {&version_, &fields_, &size_,      &type_,   &count_,
                            &width_,   &height_, &viewpoint_, &points_, &data_};
    const auto found = std::find(std::begin(kKeys), std::end(kKeys), key);
    return found == std::end(kKeys) ? nullptr : slots[found - std::begin(kKeys)];
  }

  Result<void> take_data() {
    const std::string word = data_.values.empty() ? "" : data_.values[0];
    if (word == "ascii")
      header_.data = PcdData::Ascii;
    else if (word == "binary")
      header_.data = PcdData::Binary;
    else if (word == "binary_compressed")
      header_.data = PcdData::Compressed;
    else
      return wrong(data_, "found DATA " + quoted(word) + ", wanted ascii, binary or binary_compressed");
    return {};
  }

  Result<void> same_length(const Given& given, const char* name) const {
    if (given.line == 0 || given.values.size() == fields_.values.size()) return {};
    return wrong(given, "found " + std::to_string(given.values.size()) + " values in " + name + ", wanted " +
                            std::to_string(fields_.values.size()) + ", one per field");
  }

  Result<void> take_fields() {
    if (fields_.line == 0 || fields_.values.empty())
      return fail(Code::BadInput, "the PCD header has no line FIELDS", source_.name());
    TRY(same_length(size_, "SIZE"));
    TRY(same_length(type_, "TYPE"));
    TRY(same_length(count_, "COUNT"));
    if ((size_.line == 0 || type_.line == 0) && header_.data != PcdData::Ascii)
      return fail(Code::BadInput, "the PCD header has no line SIZE or TYPE, which binary data needs", source_.name());
    for (std::size_t i = 0; i < fields_.values.size(); ++i) {
      PcdField field;
      field.name = fields_.values[i];
      if (size_.line != 0) {
        const auto size = whole(size_.values[i]);
        if (!size || (*size != 1 && *size != 2 && *size != 4 && *size != 8))
          return wrong(size_, "found the size " + quoted(size_.values[i]) + ", wanted 1, 2, 4 or 8");
        field.size = *size;
      }
      if (type_.line != 0) {
        if (type_.values[i] != "F" && type_.values[i] != "I" && type_.values[i] != "U")
          return wrong(type_, "found the type " + quoted(type_.values[i]) + ", wanted F, I or U");
        field.type = type_.values[i][0];
      }
      if (count_.line != 0) {
        const auto count = whole(count_.values[i]);
        if (!count || *count > (1u << 24))
          return wrong(count_, "found the count " + quoted(count_.values[i]) + ", wanted a whole number below 2^24");
        field.count = *count;
      }
      field.offset = header_.stride;
      field.word = header_.words;
      header_.stride += field.size * field.count;
      header_.words += field.count;
      header_.fields.push_back(std::move(field));
    }
    return {};
  }

  Result<void> find_xyz() {
    static constexpr const char* kNames[] = {"x", "y", "z"};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      std::size_t found = 0;
      for (std::size_t i = 0; i < header_.fields.size(); ++i) {
        const std::string& name = header_.fields[i].name;
        if (name.size() != 1 || (name[0] != "xyz"[axis] && name[0] != "XYZ"[axis])) continue;
        header_.xyz[axis] = i;
        ++found;
      }
      if (found != 1)
        return wrong(fields_, "found " + std::to_string(found) + " fields named " + kNames[axis] + ", wanted one");
      const PcdField& field = header_.fields[header_.xyz[axis]];
      if (field.count != 1)
        return wrong(count_, std::string("found the count ") + std::to_string(field.count) + " for " + kNames[axis] +
                                 ", wanted 1");
      TRY_ASSIGN(header_.xyz_type[axis], type_of(field));
    }
    return {};
  }

  Result<PlyType> type_of(const PcdField& field) const {
    if (field.type == 'F' && field.size == 4) return PlyType::Float32;
    if (field.type == 'F' && field.size == 8) return PlyType::Float64;
    const bool is_signed = field.type == 'I';
    if (field.type != 'F' && field.size == 1) return is_signed ? PlyType::Int8 : PlyType::UInt8;
    if (field.type != 'F' && field.size == 2) return is_signed ? PlyType::Int16 : PlyType::UInt16;
    if (field.type != 'F' && field.size == 4) return is_signed ? PlyType::Int32 : PlyType::UInt32;
    if (header_.data == PcdData::Ascii) return PlyType::Float64;  // not used
    return wrong(type_, std::string("found ") + field.type + std::to_string(field.size) + " for " + field.name +
                            "; coordinates are read as F4, F8 and whole numbers of 1, 2 or 4 bytes");
  }

  Result<std::optional<std::uint64_t>> one_number(const Given& given, const char* name) const {
    if (given.line == 0) return std::optional<std::uint64_t>();
    const auto value = given.values.size() == 1 ? whole(given.values[0]) : std::nullopt;
    if (!value) return wrong(given, std::string("wanted one whole number in ") + name);
    return value;
  }

  Result<void> take_points() {
    TRY_ASSIGN(const auto width, one_number(width_, "WIDTH"));
    TRY_ASSIGN(const auto height, one_number(height_, "HEIGHT"));
    TRY_ASSIGN(const auto points, one_number(points_, "POINTS"));
    std::optional<std::uint64_t> cells;
    if (width) {
      const std::uint64_t rows = height.value_or(1);
      if (rows > 0 && *width > kMost / rows)
        return wrong(width_, "found WIDTH " + std::to_string(*width) + " x HEIGHT " + std::to_string(rows) +
                                 ", more points than any file holds");
      cells = *width * rows;
    }
    if (!points && !cells) return fail(Code::BadInput, "the PCD header has neither POINTS nor WIDTH", source_.name());
    header_.points = points ? *points : *cells;
    if (cells && *cells != header_.points) header_.cells = cells;
    header_.is_grid = width && height && *width > 1 && *height > 1 && !header_.cells;
    return {};
  }

  Result<void> take_viewpoint() {
    if (viewpoint_.line == 0) return {};
    std::array<double, 7> v{};
    bool good = viewpoint_.values.size() == 7;
    for (std::size_t i = 0; good && i < 7; ++i) {
      const auto value = parse_number(viewpoint_.values[i]);
      good = value && std::isfinite(*value);
      v[i] = value.value_or(0);
    }
    if (!good) return wrong(viewpoint_, "wanted seven numbers tx ty tz qw qx qy qz in VIEWPOINT");
    const bool is_default = v == std::array<double, 7>{0, 0, 0, 1, 0, 0, 0};
    if (!is_default || header_.is_grid) header_.eye = Vec3{v[0], v[1], v[2]};
    return {};
  }

  const ByteSource& source_;
  Cursor cursor_;
  PcdHeader header_;
  Given version_, fields_, size_, type_, count_, width_, height_, viewpoint_, points_, data_;
};

}  // namespace

Result<PcdHeader> read_pcd_header(const ByteSource& source) { return HeaderPass(source).run(); }

}  // namespace scanmill::formats
