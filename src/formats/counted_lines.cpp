// SPDX-License-Identifier: Apache-2.0
#include "formats/counted_lines.hpp"

#include <cmath>

#include "formats/decimal.hpp"

namespace scanmill::formats {

bool CountedLines::Line::is_count() const {
  return numbers.size() == 1 && numbers[0] >= 0 && numbers[0] < 0x1p53 && numbers[0] == std::floor(numbers[0]);
}

Result<std::string_view> CountedLines::raw_line() {
  std::string_view text;
  if (!cursor_.line_at_hand(text)) {
    TRY_ASSIGN(text, cursor_.line());
  }
  if (text.size() > kMaxLine)
    return fail(Code::BadInput, "the line is longer than 1 MiB; this is no text file of points",
                line_place(source_.name(), line_));
  ++line_;
  return text;
}

Result<CountedLines::Line> CountedLines::next() {
  while (!cursor_.at_end()) {
    const bool first = cursor_.offset() == 0;
    TRY_ASSIGN(std::string_view text, raw_line());
    if (first && text.substr(0, 3) == "\xef\xbb\xbf") text.remove_prefix(3);
    if (is_comment_or_blank(text)) continue;
    Line line;
    line.line = line_ - 1;
    line.text = text.substr(0, 80);
    for (const std::string_view word : columns_of(text)) {
      double value = 0;
      const char* const end = word.data() + word.size();
      if (line.numbers.size() == 32 || word.empty() || parse_decimal(word.data(), end, value) != end) {
        line.numbers.clear();
        break;
      }
      line.numbers.push_back(value);
    }
    return line;
  }
  return Line{};
}

Result<std::vector<TextRun>> CountedLines::rows(std::uint64_t count, std::uint64_t& found) {
  TextRuns runs;
  for (found = 0; found < count && !cursor_.at_end();) {
    const std::uint64_t at = cursor_.offset();
    TRY_ASSIGN(const std::string_view text, raw_line());
    const bool is_data = is_data_line(text);
    runs.add(at, line_ - 1, is_data);
    found += is_data ? 1 : 0;
  }
  runs.close(cursor_.offset());
  return runs.take();
}

}  // namespace scanmill::formats
