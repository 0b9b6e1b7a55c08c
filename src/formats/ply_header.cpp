// SPDX-License-Identifier: Apache-2.0
#include "formats/ply_header.hpp"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cstring>

#include "base/text.hpp"
#include "formats/cursor.hpp"
#include "formats/decimal.hpp"

namespace scanmill::formats {
namespace {

constexpr std::uint64_t kMaxHeader = 1 << 20;

struct TypeName {
  std::string_view name;
  PlyType type;
};
constexpr TypeName kTypes[] = {
    {"char", PlyType::Int8},       {"uchar", PlyType::UInt8},    {"short", PlyType::Int16},
    {"ushort", PlyType::UInt16},   {"int", PlyType::Int32},      {"uint", PlyType::UInt32},
    {"float", PlyType::Float32},   {"double", PlyType::Float64}, {"int8", PlyType::Int8},
    {"uint8", PlyType::UInt8},     {"int16", PlyType::Int16},    {"uint16", PlyType::UInt16},
    {"int32", PlyType::Int32},     {"uint32", PlyType::UInt32},  {"float32", PlyType::Float32},
    {"float64", PlyType::Float64},
};

bool type_from(std::string_view word, PlyType& type) {
  for (const TypeName& row : kTypes) {
    if (row.name != word) continue;
    type = row.type;
    return true;
  }
  return false;
}

template <class T>
double load_as(bool swap, const char* p) {
  char bytes[sizeof(T)];
  std::memcpy(bytes, p, sizeof(T));
  if (swap) std::reverse(bytes, bytes + sizeof(T));
  T value;
  std::memcpy(&value, bytes, sizeof(T));
  return static_cast<double>(value);
}

class Parser {
 public:
  explicit Parser(const std::string& name) : name_(name) {}

  PlyHeader header;

  /// One line behind the first; true when it was end_header.
  Result<bool> take(std::string_view line, std::uint64_t number) {
    place_ = line_place(name_, number);
    const auto words = words_of(line);
    if (words.empty()) return false;
    if (words[0] == "end_header") return finish();
    if (words[0] == "comment") {
      const auto at = static_cast<std::size_t>(words[0].data() - line.data()) + words[0].size();
      std::string_view text = line.substr(std::min(at + 1, line.size()));
      while (!text.empty() && text.back() == '\r') text.remove_suffix(1);
      header.comments.emplace_back(text);
    } else if (words[0] == "format") {
      TRY(take_format(words));
    } else if (words[0] == "element") {
      TRY(take_element(words, line));
    } else if (words[0] == "property") {
      TRY(take_property(words, line));
    } else if (words[0] != "obj_info") {
      note("line " + std::to_string(number) + " of the header is not known and was skipped: " + quoted(line));
    }
    return false;
  }

 private:
  Error wrong(std::string message) const { return fail(Code::BadInput, std::move(message), place_); }
  void note(std::string text) {
    if (header.notes.size() < 20) header.notes.push_back(std::move(text));
  }

  Result<void> take_format(const std::vector<std::string_view>& words) {
    if (has_format_) return wrong("the format is given a second time");
    has_format_ = true;
    if (words.size() >= 2 && words[1] == "ascii")
      header.encoding = PlyEncoding::Ascii;
    else if (words.size() >= 2 && words[1] == "binary_little_endian")
      header.encoding = PlyEncoding::LittleEndian;
    else if (words.size() >= 2 && words[1] == "binary_big_endian")
      header.encoding = PlyEncoding::BigEndian;
    else
      return wrong("found format " + quoted(words.size() < 2 ? std::string_view{} : words[1]) +
                   ", wanted ascii, binary_little_endian or binary_big_endian");
    if (words.size() < 3 || words[2] != "1.0") note("the format version is not 1.0; read as 1.0");
    return {};
  }

  Result<void> take_element(const std::vector<std::string_view>& words, std::string_view line) {
    PlyElement element;
    if (words.size() != 3) return wrong("found " + quoted(line) + ", wanted \"element NAME COUNT\"");
    const auto [end, error] = std::from_chars(words[2].data(), words[2].data() + words[2].size(), element.count);
    if (error != std::errc{} || end != words[2].data() + words[2].size())
      return wrong("found count " + quoted(words[2]) + " of element " + quoted(words[1]) +
                   ", wanted a whole number from 0 to 2^64 - 1");
    element.name = words[1];
    if (header.find(element.name) >= 0) return wrong("element " + quoted(words[1]) + " is declared a second time");
    header.elements.push_back(std::move(element));
    return {};
  }

  Result<void> take_property(const std::vector<std::string_view>& words, std::string_view line) {
    if (header.elements.empty()) return wrong("a property stands before any element");
    PlyElement& element = header.elements.back();
    PlyProperty property;
    property.is_list = words.size() >= 2 && words[1] == "list";
    if (words.size() != (property.is_list ? 5u : 3u))
      return wrong("found " + quoted(line) + ", wanted \"property TYPE NAME\" or \"property list TYPE TYPE NAME\"");
    if (property.is_list && !type_from(words[2], property.count_type)) return unknown_type(words[2]);
    if (property.is_list && (property.count_type == PlyType::Float32 || property.count_type == PlyType::Float64))
      return wrong("the length of a list is of type " + quoted(words[2]) + ", wanted a whole-number type");
    if (!type_from(words[words.size() - 2], property.type)) return unknown_type(words[words.size() - 2]);
    property.name = words.back();
    for (const PlyProperty& other : element.properties)
      if (other.name == property.name)
        return wrong("property " + quoted(property.name) + " of element " + quoted(element.name) +
                     " is declared a second time");
    element.has_lists |= property.is_list;
    element.stride += size_of(property.type);
    element.properties.push_back(std::move(property));
    return {};
  }

  Error unknown_type(std::string_view word) const {
    return wrong("found type " + quoted(word) +
                 ", wanted char, uchar, short, ushort, int, uint, float, double or int8, "
                 "uint8, int16, uint16, int32, uint32, float32, float64");
  }

  Result<bool> finish() {
    if (!has_format_) return wrong("the header has no format line; wanted \"format ascii 1.0\" or a binary one");
    for (const PlyElement& element : header.elements)
      if (element.count > 0 && element.properties.empty())
        return wrong("element " + quoted(element.name) + " has " + std::to_string(element.count) +
                     " rows but no property; its rows cannot be told apart");
    return true;
  }

  const std::string& name_;
  std::string place_;
  bool has_format_ = false;
};

/// Rows of numbers under a name that ends in .ply.
std::string hint_of(const std::vector<std::string_view>& words) {
  double number = 0;
  if (words.size() < 3) return {};
  for (const std::string_view word : words)
    if (parse_decimal(word.data(), word.data() + word.size(), number) != word.data() + word.size()) return {};
  return "; rows of numbers are read with format: text in the job (--format text)";
}

}  // namespace

std::size_t size_of(PlyType type) {
  static constexpr std::size_t kSizes[] = {1, 1, 2, 2, 4, 4, 4, 8};
  return kSizes[static_cast<std::size_t>(type)];
}

double load_value(PlyType type, bool swap, const char* p) {
  switch (type) {
    case PlyType::Int8:
      return load_as<std::int8_t>(swap, p);
    case PlyType::UInt8:
      return load_as<std::uint8_t>(swap, p);
    case PlyType::Int16:
      return load_as<std::int16_t>(swap, p);
    case PlyType::UInt16:
      return load_as<std::uint16_t>(swap, p);
    case PlyType::Int32:
      return load_as<std::int32_t>(swap, p);
    case PlyType::UInt32:
      return load_as<std::uint32_t>(swap, p);
    case PlyType::Float32:
      return load_as<float>(swap, p);
    case PlyType::Float64:
      return load_as<double>(swap, p);
  }
  return 0;
}

int PlyElement::find_scalar(std::string_view property) const {
  for (std::size_t i = 0; i < properties.size(); ++i)
    if (!properties[i].is_list && properties[i].name == property) return static_cast<int>(i);
  return -1;
}

bool PlyHeader::swaps_bytes() const {
  return encoding == (std::endian::native == std::endian::little ? PlyEncoding::BigEndian : PlyEncoding::LittleEndian);
}

const char* PlyHeader::format_name() const {
  static constexpr const char* kNames[] = {"ply ascii", "ply binary_little_endian", "ply binary_big_endian"};
  return kNames[static_cast<std::size_t>(encoding)];
}

int PlyHeader::find(std::string_view element) const {
  for (std::size_t i = 0; i < elements.size(); ++i)
    if (elements[i].name == element) return static_cast<int>(i);
  return -1;
}

bool looks_like_ply(std::string_view first_bytes) {
  if (first_bytes.substr(0, 3) != "ply") return false;
  return first_bytes.size() == 3 || std::string_view(" \t\r\n").find(first_bytes[3]) != std::string_view::npos;
}

Result<PlyHeader> read_ply_header(const ByteSource& source) {
  if (source.size() == 0)
    return fail(Code::BadInput, "the file is empty (0 bytes), wanted a PLY header", source.name());
  Cursor cursor(source, 0, 1 << 14);
  Parser parser(source.name());
  TRY_ASSIGN(const std::string_view first, cursor.line());
  const auto words = words_of(first);
  if (words.size() != 1 || words[0] != "ply")
    return fail(Code::BadInput, "found " + quoted(first) + ", wanted \"ply\" as the first line" + hint_of(words),
                line_place(source.name(), 1));
  for (std::uint64_t number = 2; !cursor.at_end() && cursor.offset() < kMaxHeader; ++number) {
    TRY_ASSIGN(const std::string_view line, cursor.line());
    TRY_ASSIGN(const bool done, parser.take(line, number));
    if (!done) continue;
    parser.header.data_offset = cursor.offset();
    parser.header.data_line = number + 1;
    return std::move(parser.header);
  }
  return fail(Code::BadInput,
              cursor.at_end() ? "the file ends inside its header; wanted a line end_header"
                              : "no line end_header within the first MiB",
              byte_place(source.name(), cursor.offset()));
}

}  // namespace scanmill::formats
