// SPDX-License-Identifier: Apache-2.0
// Text files of points as blocks of about 1 MiB. One pass at opening finds where lines begin and counts them; the
// numbers are read when a block is asked for, by any thread.
#include "formats/cursor.hpp"
#include "formats/readers.hpp"
#include "formats/text_rows.hpp"

namespace scanmill::formats {
namespace {

constexpr std::size_t kStart = 1 << 16;  // what is looked at to find the columns

/// One pass over the lines behind the header.
Result<std::vector<TextRun>> index_lines(const ByteSource& source, std::uint64_t offset, std::uint64_t line) {
  TextRuns runs;
  Cursor cursor(source, offset, kTextRunBytes);
  while (!cursor.at_end()) {
    const std::uint64_t at = cursor.offset();
    std::string_view text;
    if (!cursor.line_at_hand(text)) {
      TRY_ASSIGN(text, cursor.line());
    }
    if (text.size() > kMaxLine)
      return fail(Code::BadInput, "the line is longer than 1 MiB; this is no text file of points",
                  line_place(source.name(), line));
    runs.add(at, line, is_data_line(text));
    ++line;
  }
  runs.close(source.size());
  return runs.take();
}

class TextReader final : public ViewReader {
 public:
  TextReader(std::shared_ptr<const ByteSource> source, TextStart start, std::vector<TextRun> runs)
      : source_(std::move(source)), columns_(start.columns), runs_(std::move(runs)) {
    header_.format = "text";
    header_.row_meaning = RowMeaning::LineFromOne;
    for (const TextRun& run : runs_) header_.rows += run.rows;
    header_.mm_per_unit = start.mm_per_unit;
    header_.notes = std::move(start.notes);
  }

  const ViewHeader& header() const override { return header_; }
  std::size_t block_count() const override { return runs_.size(); }
  Result<void> read_block(std::size_t number, PointBlock& out) const override {
    return read_text_run(*source_, runs_[number], columns_, false, out);
  }

 private:
  std::shared_ptr<const ByteSource> source_;
  TextColumns columns_;
  std::vector<TextRun> runs_;
  ViewHeader header_;
};

}  // namespace

Result<std::unique_ptr<ViewReader>> open_text(std::shared_ptr<const ByteSource> source) {
  if (source->size() == 0)
    return fail(Code::BadInput, "the file is empty (0 bytes), wanted lines of three numbers", source->name());
  std::string text(std::min<std::uint64_t>(source->size(), kStart), '\0');
  TRY(read_exactly(*source, 0, std::span<char>(text.data(), text.size())));
  TRY_ASSIGN(TextStart start, judge_start(text, text.size() == source->size(), source->name()));
  if (!start.has_data && text.size() < source->size())
    return fail(Code::BadInput, "no line with three numbers within the first 64 KiB; this is no file of points",
                source->name());
  TRY_ASSIGN(std::vector<TextRun> runs, index_lines(*source, start.data_offset, start.data_line));
  auto reader = std::make_unique<TextReader>(source, start, std::move(runs));
  if (start.declared_points && *start.declared_points != reader->header().rows)
    return fail(Code::BadInput,
                "the first line declares " + std::to_string(*start.declared_points) + " points, the file holds " +
                    std::to_string(reader->header().rows) + " lines of numbers; it was cut or the count is wrong",
                source->name());
  return std::unique_ptr<ViewReader>(std::move(reader));
}

}  // namespace scanmill::formats
