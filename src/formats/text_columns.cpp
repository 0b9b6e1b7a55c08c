// SPDX-License-Identifier: Apache-2.0
#include "formats/text_columns.hpp"

#include "formats/cursor.hpp"
#include "formats/decimal.hpp"

namespace scanmill::formats {
namespace {

/// Passes over what stands between two numbers; `kind` is the separator met, a blank when there were blanks alone.
/// Tabs in a row are left to read_columns: they align columns or hold an empty cell.
const char* skip_separator(const char* p, const char* end, char& kind) {
  kind = ' ';
  for (; p != end && *p != '\n' && (*p == ' ' || *p == '\t' || *p == ',' || *p == ';'); ++p) {
    if (*p == ' ') continue;
    if (kind != ' ' && (*p != '\t' || kind == '\t')) return nullptr;
    if (kind == ' ') kind = *p;
  }
  return p;
}

}  // namespace

bool is_comment_or_blank(std::string_view line) {
  const auto first = line.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return true;
  const char c = line[first];
  return c == '#' || c == ';' || c == '!' || c == '%' ||
         (c == '/' && first + 1 < line.size() && line[first + 1] == '/');
}

const char* read_plain(const char* p, const char* end, Vec3& position) {
  while (p != end && *p == ' ') ++p;
  char first = 0, second = 0;
  p = p == end ? nullptr : parse_decimal(p, end, position.x);
  if (p == nullptr || p == end) return nullptr;
  const char* from = p;
  p = skip_separator(p, end, first);
  if (p == nullptr || p == from || p == end) return nullptr;
  p = from = parse_decimal(p, end, position.y);
  if (p == nullptr || p == end) return nullptr;
  p = skip_separator(p, end, second);
  if (p == nullptr || p == from || p == end || first != second) return nullptr;
  p = parse_decimal(p, end, position.z);
  if (p == nullptr) return nullptr;
  return p == end || *p == ' ' || *p == '\t' || *p == ',' || *p == ';' || *p == '\r' || *p == '\n' ? p : nullptr;
}

Error decimal_commas(std::string_view line, const std::string& name, std::uint64_t number) {
  return fail(Code::BadInput, "found decimal commas in " + quoted(trimmed(line)) + "; write the numbers with points",
              line_place(name, number));
}

bool has_carriage_return_inside(std::string_view line) {
  const auto at = line.find('\r');
  return at != std::string_view::npos && line.find_first_not_of('\r', at) != std::string_view::npos;
}

Result<Vec3> read_columns(std::string_view line, const TextColumns& columns, const std::string& name,
                          std::uint64_t number) {
  if (has_carriage_return_inside(line))
    return fail(Code::BadInput,
                "found a carriage return in the middle of the line; convert the file to usual line ends",
                line_place(name, number));
  if (columns.separator == kAnySeparator && line.find(',') != std::string_view::npos && has_decimal_commas(line))
    return decimal_commas(line, name, number);
  Vec3 position;
  const auto words = cells_of(line, columns.separator);
  double* const out[] = {&position.x, &position.y, &position.z};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::size_t column = columns.xyz[axis];
    const std::string_view word = column < words.size() ? words[column] : std::string_view{};
    if (word.empty() || parse_decimal(word.data(), word.data() + word.size(), *out[axis]) != word.data() + word.size())
      return fail(Code::BadInput, "found " + quoted(line) + ", wanted three numbers", line_place(name, number));
  }
  return position;
}

}  // namespace scanmill::formats
