// SPDX-License-Identifier: Apache-2.0
// Runs of text lines that are read as one block.
#pragma once
#include "cloud/cloud.hpp"
#include "formats/cursor.hpp"
#include "formats/text_columns.hpp"

namespace scanmill::formats {

/// About this many bytes are one block.
constexpr std::uint64_t kTextRunBytes = 1 << 20;

struct TextRun {
  std::uint64_t offset = 0, end = 0;  // of its first line, behind its last
  std::uint64_t line = 1;             // number of the first line
  std::uint64_t rows = 0;             // lines of numbers in it
};

/// Whether a line is neither blank nor a comment; most begin with a number, only the others need a look.
inline bool is_data_line(std::string_view line) {
  return (!line.empty() && ((line[0] >= '0' && line[0] <= '9') || line[0] == '-')) || !is_comment_or_blank(line);
}

/// Collects the runs of one scan while an index pass walks over its lines.
class TextRuns {
 public:
  /// The next line; `is_data` as above.
  void add(std::uint64_t offset, std::uint64_t line, bool is_data) {
    if (runs_.empty() || offset - runs_.back().offset >= kTextRunBytes) {
      close(offset);
      runs_.push_back({offset, offset, line, 0});
    }
    runs_.back().rows += is_data ? 1 : 0;
  }
  void close(std::uint64_t end) {
    if (!runs_.empty()) runs_.back().end = end;
  }
  std::vector<TextRun> take() { return std::move(runs_); }

 private:
  std::vector<TextRun> runs_;
};

/// Positions and line numbers of one run; `zero_is_empty`: a cell 0 0 0 holds no measurement.
/// errors  BadInput `file:line: found "...", wanted three numbers`; IoFailed when the file changed
Result<void> read_text_run(const ByteSource& source, const TextRun& run, const TextColumns& columns, bool zero_is_empty,
                           PointBlock& out);

}  // namespace scanmill::formats
