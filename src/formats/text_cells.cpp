// SPDX-License-Identifier: Apache-2.0
#include "formats/text_cells.hpp"

#include <algorithm>
#include <utility>

#include "formats/decimal.hpp"

namespace scanmill::formats {
namespace {

bool is_blank(char c) { return c == ' ' || c == '\t'; }
bool is_separator(char c) { return c == ',' || c == ';'; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }
char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

/// mm of a unit of length; 0 for any other word.
double mm_of_unit(std::string_view word) {
  static constexpr std::pair<std::string_view, double> kUnits[] = {
      {"mm", 1}, {"cm", 10}, {"m", 1000}, {"in", 25.4}, {"inch", 25.4}, {"um", 0.001}, {"\xc2\xb5m", 0.001}};
  for (const auto& [unit, mm] : kUnits)
    if (word.size() == unit.size() &&
        std::equal(word.begin(), word.end(), unit.begin(), [](char a, char b) { return lower(a) == b; }))
      return mm;
  return 0;
}

bool is_bracketed(std::string_view word) {
  return word.size() >= 2 &&
         ((word.front() == '[' && word.back() == ']') || (word.front() == '(' && word.back() == ')') ||
          (word.front() == '{' && word.back() == '}'));
}

/// 0, 1, 2 for x, y, z; 3 for anything else. `mm` becomes the unit behind it, 0 where none is known.
std::size_t axis_of(std::string_view cell, double& mm) {
  mm = 0;
  if (cell.empty()) return 3;
  const char c = lower(cell.front());
  if (c < 'x' || c > 'z') return 3;
  std::string_view rest = trimmed(cell.substr(1));
  const bool parted = rest.size() + 1 < cell.size();
  const bool marked = !rest.empty() && (rest.front() == '_' || rest.front() == '/');
  if (marked) rest = trimmed(rest.substr(1));
  const bool bracketed = is_bracketed(rest);
  mm = mm_of_unit(bracketed ? trimmed(rest.substr(1, rest.size() - 2)) : rest);
  const bool names = rest.empty() ? !marked : bracketed || ((parted || marked) && mm > 0);
  return names ? static_cast<std::size_t>(c - 'x') : 3;
}

}  // namespace

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && (is_blank(text.back()) || text.back() == '\r')) text.remove_suffix(1);
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  return text;
}

bool is_number(std::string_view word) {
  double value = 0;
  return !word.empty() && parse_decimal(word.data(), word.data() + word.size(), value) == word.data() + word.size();
}

std::vector<std::string_view> columns_of(std::string_view line) {
  std::vector<std::string_view> words;
  line = trimmed(line);
  std::size_t at = 0;
  while (at < line.size()) {
    std::size_t end = at;
    if (line[at] == '"') {
      end = line.find('"', at + 1);
      if (end == std::string_view::npos) end = line.size();
      words.push_back(trimmed(line.substr(at + 1, end - at - 1)));
      if (end < line.size()) ++end;
    } else {
      while (end < line.size() && !is_blank(line[end]) && !is_separator(line[end])) ++end;
      words.push_back(line.substr(at, end - at));
    }
    while (end < line.size() && is_blank(line[end])) ++end;
    if (end < line.size() && is_separator(line[end])) ++end;
    while (end < line.size() && is_blank(line[end])) ++end;
    at = end;
  }
  return words;
}

std::vector<std::string_view> cells_of(std::string_view line, char separator) {
  if (separator == kAnySeparator) return columns_of(line);
  while (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  std::vector<std::string_view> cells;
  for (std::size_t at = 0;;) {
    const std::size_t begin = std::min(line.find_first_not_of(' ', at), line.size());
    std::size_t end = begin;
    if (begin < line.size() && line[begin] == '"') end = std::min(line.find('"', begin + 1), line.size());
    end = std::min(line.find(separator, end), line.size());
    std::string_view cell = trimmed(line.substr(at, end - at));
    if (cell.size() >= 2 && cell.front() == '"' && cell.back() == '"') cell = trimmed(cell.substr(1, cell.size() - 2));
    cells.push_back(cell);
    if (end == line.size()) return cells;
    at = end + 1;
  }
}

char separator_of_numbers(std::string_view line) {
  for (const char separator : {';', ',', '\t'}) {
    if (line.find(separator) == std::string_view::npos) continue;
    const auto cells = cells_of(line, separator);
    if (separator == '\t' && std::any_of(cells.begin(), cells.end(), [](auto cell) { return cell.empty(); })) continue;
    if (std::count_if(cells.begin(), cells.end(), is_number) >= 3) return separator;
  }
  return kAnySeparator;
}

bool is_decimal_comma(std::string_view cell) {
  if (!cell.empty() && (cell.front() == '-' || cell.front() == '+')) cell.remove_prefix(1);
  const auto comma = cell.find(',');
  if (comma == std::string_view::npos || comma == 0 || comma + 1 == cell.size()) return false;
  std::size_t digits = 0;
  bool grouped = false;
  for (const char c : cell.substr(0, comma)) {
    if (!is_digit(c) && (c != '.' || digits == 0 || (grouped && digits != 3))) return false;
    grouped |= c == '.';
    digits = c == '.' ? 0 : digits + 1;
  }
  if (digits == 0 || (grouped && digits != 3)) return false;
  const std::string_view fraction = cell.substr(comma + 1);
  return is_digit(fraction.front()) && fraction.find('.') == std::string_view::npos && is_number(fraction);
}

bool has_decimal_commas(std::string_view line) {
  const bool semicolons = line.find(';') != std::string_view::npos;
  std::size_t fields = 0, with_comma = 0;
  for (std::size_t at = 0; at < line.size();) {
    const std::size_t begin = line.find_first_not_of(" \t;", at);
    if (begin == std::string_view::npos) break;
    at = std::min(line.find_first_of(" \t;", begin), line.size());
    ++fields;
    with_comma += is_decimal_comma(trimmed(line.substr(begin, at - begin)));
  }
  return fields >= 3 && (with_comma == fields || (semicolons && with_comma > 0));
}

AxisNames axis_names(const std::vector<std::string_view>& cells) {
  AxisNames names;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    double mm = 0;
    const std::size_t axis = axis_of(cells[i], mm);
    if (axis == 3) continue;
    names.mm[axis] = mm;
    names.place[axis] = static_cast<std::uint32_t>(i);
    ++names.count[axis];
  }
  return names;
}

std::vector<std::string_view> header_cells(std::string_view line, char separator_of_data) {
  line = trimmed(line);
  if (separator_of_data != kAnySeparator && line.find(separator_of_data) != std::string_view::npos)
    return cells_of(line, separator_of_data);
  for (const char separator : {';', ',', '\t'})
    if (line.find(separator) != std::string_view::npos) {
      auto cells = cells_of(line, separator);
      if (separator == '\t') std::erase_if(cells, [](std::string_view cell) { return cell.empty(); });
      return cells;
    }
  std::vector<std::string_view> names;
  for (const std::string_view word : columns_of(line)) {
    if (names.empty() || !is_bracketed(word))
      names.push_back(word);
    else  // as far as the end of the bracket
      names.back() = {names.back().data(), static_cast<std::size_t>(word.data() + word.size() - names.back().data())};
  }
  return names;
}

}  // namespace scanmill::formats
