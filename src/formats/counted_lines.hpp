// SPDX-License-Identifier: Apache-2.0
// One walk over a text file whose headers say how many lines of numbers follow (PTS, PTX).
#pragma once
#include <string>

#include "formats/text_rows.hpp"

namespace scanmill::formats {

class CountedLines {
 public:
  explicit CountedLines(const ByteSource& source) : source_(source), cursor_(source, 0, kTextRunBytes) {}

  struct Line {
    std::vector<double> numbers;  // empty at the end of the file
    std::uint64_t line = 0;
    std::string text;  // as written, for messages
    bool at_end() const { return line == 0; }
    /// One whole number of 0 or more, below 2^53.
    bool is_count() const;
    std::uint64_t count() const { return static_cast<std::uint64_t>(numbers[0]); }
  };
  /// The next line that is neither blank nor a comment, as numbers (none where a word is not a number).
  Result<Line> next();
  /// Runs of the next `count` lines of numbers; `found` is how many there are (fewer only at the end of the file).
  Result<std::vector<TextRun>> rows(std::uint64_t count, std::uint64_t& found);
  std::uint64_t line_number() const { return line_; }

 private:
  Result<std::string_view> raw_line();

  const ByteSource& source_;
  Cursor cursor_;
  std::uint64_t line_ = 1;  // of the next line
};

}  // namespace scanmill::formats
