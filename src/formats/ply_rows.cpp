// SPDX-License-Identifier: Apache-2.0
#include "formats/ply_rows.hpp"

#include "formats/decimal.hpp"

namespace scanmill::formats {
namespace {

bool is_space(char c) { return c == ' ' || c == '\t' || c == '\r'; }

/// Words of one line, one after the other.
class Words {
 public:
  explicit Words(std::string_view line) : p_(line.data()), end_(line.data() + line.size()) {}
  bool skip() { return !next().empty(); }
  /// False when no word is left or it is no number; `word` shows which.
  bool number(double& value, std::string_view& word) {
    while (p_ != end_ && is_space(*p_)) ++p_;
    const char* stop = p_ == end_ ? nullptr : parse_decimal(p_, end_, value);
    if (stop == nullptr || (stop != end_ && !is_space(*stop))) {
      word = next();
      return false;
    }
    p_ = stop;
    return true;
  }
  std::string_view next() {
    while (p_ != end_ && is_space(*p_)) ++p_;
    const char* begin = p_;
    while (p_ != end_ && !is_space(*p_)) ++p_;
    return {begin, static_cast<std::size_t>(p_ - begin)};
  }

 private:
  const char* p_;
  const char* end_;
};

}  // namespace

Result<void> read_ascii_row(std::string_view line, const PlyElement& element, std::span<const int> wanted,
                            std::span<double> values, const std::string& name, std::uint64_t line_number) {
  Words words(line);
  std::size_t found = 0;
  auto wrong = [&](const PlyProperty& property, std::string_view word) {
    return fail(Code::BadInput,
                word.empty() ? "found " + quoted(line) + ", the line ends before property " + quoted(property.name) +
                                   " of element " + quoted(element.name)
                             : "found " + quoted(word) + " as " + quoted(property.name) + ", wanted a number",
                line_place(name, line_number));
  };
  for (std::size_t i = 0; i < element.properties.size(); ++i) {
    const PlyProperty& property = element.properties[i];
    std::string_view word;
    if (property.is_list) {
      double count = 0;
      if (!words.number(count, word)) return wrong(property, word);
      if (!(count >= 0)) return wrong(property, "a negative length");
      for (double k = 0; k < count; ++k)
        if (!words.skip()) return wrong(property, {});
    } else if (found < wanted.size() && wanted[found] == static_cast<int>(i)) {
      if (!words.number(values[found++], word)) return wrong(property, word);
    } else if (!words.skip()) {
      return wrong(property, {});
    }
  }
  if (const std::string_view rest = words.next(); !rest.empty())
    return fail(Code::BadInput,
                "found " + quoted(rest) + " behind the last of the " + std::to_string(element.properties.size()) +
                    " properties that the header declares for element " + quoted(element.name),
                line_place(name, line_number));
  return {};
}

Result<void> read_binary_row(Cursor& cursor, const ByteSource& source, const PlyHeader& header,
                             const PlyElement& element, std::span<const int> wanted, std::span<double> values,
                             std::uint64_t row) {
  std::size_t found = 0;
  for (std::size_t i = 0; i < element.properties.size(); ++i) {
    const PlyProperty& property = element.properties[i];
    if (!property.is_list && found < wanted.size() && wanted[found] == static_cast<int>(i)) {
      TRY_ASSIGN(const std::string_view bytes, cursor.peek(size_of(property.type)));
      if (bytes.size() < size_of(property.type))
        return fail(Code::BadInput,
                    "the file ends inside row " + std::to_string(row) + " of element " + quoted(element.name),
                    byte_place(source.name(), cursor.offset()));
      values[found++] = load_value(property.type, header.swaps_bytes(), bytes.data());
    }
    TRY(skip_property(cursor, source, header, element, property, row));
  }
  return {};
}

}  // namespace scanmill::formats
