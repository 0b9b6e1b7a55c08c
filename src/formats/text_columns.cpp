// SPDX-License-Identifier: Apache-2.0
#include "formats/text_columns.hpp"

#include <algorithm>

#include "formats/cursor.hpp"
#include "formats/decimal.hpp"

namespace scanmill::formats {
namespace {

constexpr std::size_t kMaxHeaderLines = 32;

bool is_blank(char c) { return c == ' ' || c == '\t'; }
bool is_separator(char c) { return c == ',' || c == ';'; }

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && (is_blank(text.back()) || text.back() == '\r')) text.remove_suffix(1);
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  return text;
}

bool is_number(std::string_view word) {
  double value = 0;
  return !word.empty() && parse_decimal(word.data(), word.data() + word.size(), value) == word.data() + word.size();
}

char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

/// How often each of x, y, z is a word of the line, and where last.
struct Names {
  std::array<std::uint32_t, 3> place{};
  std::array<int, 3> count{};
  bool all() const { return count[0] == 1 && count[1] == 1 && count[2] == 1; }
  bool two() const { return (count[0] > 0) + (count[1] > 0) + (count[2] > 0) >= 2; }
};

Names names_in(const std::vector<std::string_view>& words) {
  Names names;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (words[i].size() != 1) continue;
    const char c = lower(words[i][0]);
    if (c < 'x' || c > 'z') continue;
    names.place[static_cast<std::size_t>(c - 'x')] = static_cast<std::uint32_t>(i);
    ++names.count[static_cast<std::size_t>(c - 'x')];
  }
  return names;
}

TextColumns make_columns(const std::array<std::uint32_t, 3>& xyz) {
  TextColumns columns{xyz, xyz, false};
  std::sort(columns.ascending.begin(), columns.ascending.end());
  columns.plain = xyz == std::array<std::uint32_t, 3>{0, 1, 2};
  return columns;
}

/// "1,5;2,5;3,5" and "1,5 2,5 3,5": read as points these would be silently wrong.
bool has_decimal_commas(std::string_view line) {
  if (line.find('.') != std::string_view::npos) return false;
  const bool semicolons = line.find(';') != std::string_view::npos;
  std::size_t fields = 0, with_comma = 0;
  for (std::size_t at = 0; at < line.size();) {
    const std::size_t begin = line.find_first_not_of(" \t;", at);
    if (begin == std::string_view::npos) break;
    at = std::min(line.find_first_of(" \t;", begin), line.size());
    const std::string_view field = line.substr(begin, at - begin);
    ++fields;
    const auto comma = field.find(',');
    with_comma += comma != std::string_view::npos && comma > 0 && comma + 1 < field.size() &&
                  field.find(',', comma + 1) == std::string_view::npos;
  }
  return fields >= 3 && (with_comma == fields || (semicolons && with_comma > 0));
}

std::string comment_text(std::string_view line) {
  line = trimmed(line);
  while (!line.empty() && (line.front() == '#' || line.front() == '/' || line.front() == ';' || line.front() == '!' ||
                           line.front() == '%'))
    line.remove_prefix(1);
  return std::string(trimmed(line));
}

class Judge {
 public:
  Judge(const std::string& name, TextStart& start) : name_(name), start_(start) {}

  /// True when the first data line was met.
  Result<bool> take(std::string_view line, std::uint64_t number) {
    if (is_comment_or_blank(line)) {
      if (!trimmed(line).empty()) remark_ = comment_text(line);
      return false;
    }
    const auto words = columns_of(line);
    const auto numbers = static_cast<std::size_t>(std::count_if(words.begin(), words.end(), is_number));
    if (numbers >= 3 && words.size() - numbers <= std::max<std::size_t>(1, is_number(words[0]) ? words.size() : 1))
      return first_data(line, words, number);
    if (words.size() == 1 && numbers == 1 && !start_.declared_points && !named_ && headers_ == 0)
      return take_count(words[0], line, number);
    if (words.empty() || is_number(words[0]) || ++headers_ > kMaxHeaderLines) return wanted_numbers(line, number);
    return take_header(line, words, number);
  }

  bool knows_columns() const { return named_; }

 private:
  Error wanted_numbers(std::string_view line, std::uint64_t number) const {
    return fail(Code::BadInput, "found " + quoted(line) + ", wanted three numbers", line_place(name_, number));
  }

  Result<bool> take_count(std::string_view word, std::string_view line, std::uint64_t number) {
    std::uint64_t count = 0;
    for (const char c : word) {
      if (c < '0' || c > '9' || count > 1000000000000000ull) return wanted_numbers(line, number);
      count = count * 10 + static_cast<std::uint64_t>(c - '0');
    }
    start_.declared_points = count;
    return false;
  }

  Result<bool> take_header(std::string_view line, const std::vector<std::string_view>& words, std::uint64_t number) {
    const Names names = names_in(words);
    if (names.all() && !named_) {
      named_ = true;
      start_.columns = make_columns(names.place);
    } else if (names.two() && !names.all() && !named_) {
      static constexpr const char* kNames[] = {"x", "y", "z"};
      for (std::size_t axis = 0; axis < 3; ++axis)
        if (names.count[axis] != 1)
          return fail(Code::BadInput,
                      "found the column names " + quoted(line) + " with " + std::to_string(names.count[axis]) +
                          " columns named " + kNames[axis] + ", wanted one each of x, y and z",
                      line_place(name_, number));
    }
    if (start_.notes.size() < 5)
      start_.notes.push_back("line " + std::to_string(number) + " is a header line: " + quoted(line));
    return false;
  }

  Result<bool> first_data(std::string_view line, const std::vector<std::string_view>& words, std::uint64_t number) {
    if (has_decimal_commas(trimmed(line)))
      return fail(Code::BadInput, "found decimal commas in " + quoted(line) + "; write the numbers with points",
                  line_place(name_, number));
    start_.has_data = true;
    if (named_) return true;
    // CloudCompare writes its column names as a comment; they count when there is one name per column.
    const auto remark_words = columns_of(remark_);
    const Names names = names_in(remark_words);
    if (names.all() && remark_words.size() == words.size()) {
      start_.columns = make_columns(names.place);
      return true;
    }
    std::array<std::uint32_t, 3> xyz{};
    std::size_t found = 0;
    for (std::size_t i = 0; i < words.size() && found < 3; ++i)
      if (is_number(words[i])) xyz[found++] = static_cast<std::uint32_t>(i);
    start_.columns = make_columns(xyz);
    return true;
  }

  const std::string& name_;
  TextStart& start_;
  std::string remark_;  // text of the comment line seen last
  std::size_t headers_ = 0;
  bool named_ = false;
};

}  // namespace

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

bool is_comment_or_blank(std::string_view line) {
  const auto first = line.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return true;
  const char c = line[first];
  return c == '#' || c == ';' || c == '!' || c == '%' ||
         (c == '/' && first + 1 < line.size() && line[first + 1] == '/');
}

Result<TextStart> judge_start(std::string_view text, bool complete, const std::string& name) {
  TextStart start;
  if (text.substr(0, 2) == "\xff\xfe" || text.substr(0, 2) == "\xfe\xff")
    return fail(Code::BadInput, "the file is UTF-16 text; save it as plain text (UTF-8)", name);
  if (text.substr(0, 3) == "\xef\xbb\xbf") start.data_offset = 3;
  const bool has_lines = text.find('\n') != std::string_view::npos;
  if (!has_lines && text.find('\r') != std::string_view::npos && text.find('\r') + 1 < text.size())
    return fail(Code::BadInput, "the lines end in a carriage return alone; convert the file to usual line ends", name);
  Judge judge(name, start);
  std::string_view first_words;
  std::uint64_t number = 1;
  for (std::size_t at = start.data_offset; at < text.size(); ++number) {
    const std::size_t end = text.find('\n', at);
    if (end == std::string_view::npos && !complete) break;
    const std::string_view line = text.substr(at, std::min(end, text.size()) - at);
    if (first_words.empty() && !is_comment_or_blank(line)) first_words = line;
    TRY_ASSIGN(const bool data, judge.take(line, number));
    start.data_offset = at;
    start.data_line = number;
    if (data) return start;
    at = std::min(end, text.size() - 1) + 1;
  }
  start.data_offset = text.size();
  start.data_line = number;
  if (!complete || judge.knows_columns() || start.declared_points || first_words.empty()) return start;
  return fail(Code::BadInput,
              "found " + quoted(first_words) + " and no line with three numbers; this is no file of points", name);
}

const char* read_plain(const char* p, const char* end, Vec3& position) {
  double* const out[] = {&position.x, &position.y, &position.z};
  for (int axis = 0; axis < 3; ++axis) {
    while (p != end && is_blank(*p)) ++p;
    if (p == end) return nullptr;
    p = parse_decimal(p, end, *out[axis]);
    if (p == nullptr) return nullptr;
    if (axis == 2) return p == end || is_blank(*p) || is_separator(*p) || *p == '\r' || *p == '\n' ? p : nullptr;
    if (p == end || (!is_blank(*p) && !is_separator(*p))) return nullptr;
    while (p != end && is_blank(*p)) ++p;
    if (p != end && is_separator(*p)) ++p;
  }
  return nullptr;
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
  Vec3 position;
  const auto words = columns_of(line);
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
