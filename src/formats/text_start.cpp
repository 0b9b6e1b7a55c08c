// SPDX-License-Identifier: Apache-2.0
// The lines before the first point: a count, titles, names of columns.
#include <algorithm>

#include "formats/cursor.hpp"
#include "formats/text_columns.hpp"

namespace scanmill::formats {
namespace {

constexpr std::size_t kMaxHeaderLines = 32;
constexpr std::size_t kMaxHeaderNotes = 5;

TextColumns make_columns(const std::array<std::uint32_t, 3>& xyz, char separator) {
  TextColumns columns{xyz, xyz, false, separator};
  std::sort(columns.ascending.begin(), columns.ascending.end());
  columns.plain = xyz == std::array<std::uint32_t, 3>{0, 1, 2};
  return columns;
}

std::string numbers_of(const std::array<std::uint32_t, 3>& xyz) {
  return std::to_string(xyz[0] + 1) + ", " + std::to_string(xyz[1] + 1) + " and " + std::to_string(xyz[2] + 1);
}

std::string_view comment_text(std::string_view line) {
  line = trimmed(line);
  while (!line.empty() && (line.front() == '#' || line.front() == '/' || line.front() == ';' || line.front() == '!' ||
                           line.front() == '%'))
    line.remove_prefix(1);
  return trimmed(line);
}

/// Three cells or more that all begin as numbers do, `0,5D+01` or `1·25`: points in a writing that is not read, no
/// header.
bool begins_as_numbers(const std::vector<std::string_view>& cells) {
  const auto begins = [](std::string_view cell) {
    const auto at = cell.find_first_not_of("+-.");
    return at != std::string_view::npos && at <= 2 && cell[at] >= '0' && cell[at] <= '9';
  };
  return cells.size() >= 3 && std::all_of(cells.begin(), cells.end(), begins);
}

struct HeaderLine {
  std::string_view text;
  std::uint64_t number = 0;
};

class Judge {
 public:
  Judge(const std::string& name, TextStart& start) : name_(name), start_(start) {}

  /// True when the first data line was met.
  Result<bool> take(std::string_view line, std::uint64_t number) {
    if (is_comment_or_blank(line)) {
      if (!trimmed(line).empty()) remark_ = {comment_text(line), number};
      return false;
    }
    const char separator = separator_of_numbers(line);
    const auto cells = cells_of(line, separator);
    const auto numbers = static_cast<std::size_t>(std::count_if(cells.begin(), cells.end(), is_number));
    const std::size_t words_allowed = !cells.empty() && is_number(cells[0]) ? cells.size() : 1;
    if (numbers >= 3 && (cells.size() - numbers <= words_allowed || names_these(cells, separator)))
      return first_data(line, cells, separator, number);
    if (cells.size() == 1 && numbers == 1 && !start_.declared_points && headers_.empty())
      return take_count(cells[0], line, number);
    if (cells.empty() || is_number(cells[0]) || begins_as_numbers(cells) || headers_.size() == kMaxHeaderLines)
      return wanted_numbers(line, number);
    headers_.push_back({line, number});
    if (start_.notes.size() < kMaxHeaderNotes)
      start_.notes.push_back("line " + std::to_string(number) + " is a header line: " + quoted(trimmed(line)));
    return false;
  }

  /// A file of a header alone holds no points, and is no prose.
  bool knows_columns() const {
    return std::any_of(headers_.begin(), headers_.end(), [](const HeaderLine& header) {
      return axis_names(header_cells(header.text, kAnySeparator)).all();
    });
  }

 private:
  Error wanted_numbers(std::string_view line, std::uint64_t number) const {
    if (has_decimal_commas(trimmed(line))) return decimal_commas(line, name_, number);
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

  /// Cells that a header names are data whatever stands beside them: `Circle,left,1,2,3` under `Name,Side,X,Y,Z`.
  bool names_these(const std::vector<std::string_view>& cells, char separator) const {
    if (headers_.empty()) return false;
    const auto names = header_cells(headers_.back().text, separator);
    const AxisNames axes = axis_names(names);
    return axes.all() && names.size() == cells.size() &&
           std::all_of(axes.place.begin(), axes.place.end(), [&](std::uint32_t at) { return is_number(cells[at]); });
  }

  Result<bool> first_data(std::string_view line, const std::vector<std::string_view>& cells, char separator,
                          std::uint64_t number) {
    if (separator == kAnySeparator && has_decimal_commas(trimmed(line))) return decimal_commas(line, name_, number);
    start_.has_data = true;
    for (auto header = headers_.rbegin(); header != headers_.rend(); ++header) {
      TRY_ASSIGN(const bool named, take_names(*header, cells, separator));
      if (named) return true;
    }
    // CloudCompare writes its column names as a comment; they count when there is one name per column.
    const auto names = header_cells(remark_.text, separator);
    if (const AxisNames axes = axis_names(names); axes.all() && names.size() == cells.size()) {
      TRY(choose(axes, names, remark_.number, separator));
      return true;
    }
    std::array<std::uint32_t, 3> xyz{};
    std::size_t found = 0;
    for (std::size_t i = 0; i < cells.size() && found < 3; ++i)
      if (is_number(cells[i])) xyz[found++] = static_cast<std::uint32_t>(i);
    start_.columns = make_columns(xyz, separator);
    if (!headers_.empty() || !start_.columns.plain)
      start_.notes.push_back("no line names x, y and z: they are taken from the columns " + numbers_of(xyz) +
                             ", the first that hold numbers");
    return true;
  }

  /// False when the line names no columns, which prose may do with any words.
  Result<bool> take_names(const HeaderLine& header, const std::vector<std::string_view>& cells, char separator) {
    const auto names = header_cells(header.text, separator);
    const AxisNames axes = axis_names(names);
    const bool by_words = header.text.find_first_of(";,\t") == std::string_view::npos;
    if (axes.all()) {
      if (!by_words || names.size() == cells.size() || (axes.side_by_side() && names.size() < cells.size())) {
        TRY(choose(axes, names, header.number, separator));
        return true;
      }
      if (!axes.side_by_side()) return false;
      return fail(Code::BadInput,
                  "found " + std::to_string(names.size()) + " words in the column names " +
                      quoted(trimmed(header.text)) + " over " + std::to_string(cells.size()) +
                      " columns, wanted one name per column; write names without blanks or with commas between",
                  line_place(name_, header.number));
    }
    if (!axes.two() || (by_words && names.size() != cells.size())) return false;
    static constexpr const char* kNames[] = {"x", "y", "z"};
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (axes.count[axis] != 1)
        return fail(Code::BadInput,
                    "found the column names " + quoted(trimmed(header.text)) + " with " +
                        std::to_string(axes.count[axis]) + " columns named " + kNames[axis] +
                        ", wanted one each of x, y and z",
                    line_place(name_, header.number));
    return false;
  }

  Result<void> choose(const AxisNames& axes, const std::vector<std::string_view>& names, std::uint64_t line,
                      char separator) {
    const auto& xyz = axes.place;
    for (const double mm : axes.mm) {
      if (mm > 0 && start_.mm_per_unit > 0 && mm != start_.mm_per_unit)
        return fail(Code::BadInput,
                    "found the columns " + quoted(names[xyz[0]]) + ", " + quoted(names[xyz[1]]) + " and " +
                        quoted(names[xyz[2]]) + ", wanted x, y and z in one unit",
                    line_place(name_, line));
      if (mm > 0) start_.mm_per_unit = mm;
    }
    start_.columns = make_columns(xyz, separator);
    if (start_.columns.plain) return {};
    start_.notes.push_back("line " + std::to_string(line) + " names the columns: x, y, z are " + numbers_of(xyz) +
                           " (" + std::string(names[xyz[0]]) + ", " + std::string(names[xyz[1]]) + ", " +
                           std::string(names[xyz[2]]) + ")");
    return {};
  }

  const std::string& name_;
  TextStart& start_;
  HeaderLine remark_;  // text of the comment line seen last
  std::vector<HeaderLine> headers_;
};

}  // namespace

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

}  // namespace scanmill::formats
