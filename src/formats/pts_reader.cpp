// SPDX-License-Identifier: Apache-2.0
// Leica PTS: a line with the number of points, then as many lines x y z [intensity [r g b]]; some programs write
// several such parts into one file. All of them lie in one frame, so they are one view.
#include "formats/counted_lines.hpp"
#include "formats/readers.hpp"

namespace scanmill::formats {
namespace {

class PtsReader final : public ViewReader {
 public:
  PtsReader(std::shared_ptr<const ByteSource> source, std::vector<TextRun> runs)
      : source_(std::move(source)), runs_(std::move(runs)) {
    header_.format = "pts";
    header_.row_meaning = RowMeaning::LineFromOne;
    for (const TextRun& run : runs_) header_.rows += run.rows;
  }

  ViewHeader& change_header() { return header_; }
  const ViewHeader& header() const override { return header_; }
  std::size_t block_count() const override { return runs_.size(); }
  Result<void> read_block(std::size_t number, PointBlock& out) const override {
    return read_text_run(*source_, runs_[number], TextColumns{}, false, out);
  }

 private:
  std::shared_ptr<const ByteSource> source_;
  std::vector<TextRun> runs_;
  ViewHeader header_;
};

}  // namespace

Result<std::unique_ptr<ViewReader>> open_pts(std::shared_ptr<const ByteSource> source) {
  CountedLines lines(*source);
  TRY_ASSIGN(CountedLines::Line line, lines.next());
  if (!line.is_count()) return open_text(std::move(source));
  std::vector<TextRun> runs;
  std::uint64_t parts = 0;
  while (!line.at_end()) {
    if (!line.is_count())
      return fail(Code::BadInput,
                  "found " + quoted(line.text) +
                      " behind the last point that was declared, wanted the number of points "
                      "of a further part or the end of the file; the count is wrong",
                  line_place(source->name(), line.line));
    std::uint64_t found = 0;
    TRY_ASSIGN(std::vector<TextRun> part, lines.rows(line.count(), found));
    if (found < line.count())
      return fail(Code::BadInput,
                  "the line declares " + std::to_string(line.count()) + " points, the file holds " +
                      std::to_string(found) + " lines of numbers behind it; it was cut or the count is wrong",
                  line_place(source->name(), line.line));
    runs.insert(runs.end(), part.begin(), part.end());
    ++parts;
    TRY_ASSIGN(line, lines.next());
  }
  auto reader = std::make_unique<PtsReader>(std::move(source), std::move(runs));
  if (parts > 1)
    reader->change_header().notes.push_back("the file holds " + std::to_string(parts) +
                                            " parts with a count each; they are taken as one view");
  return std::unique_ptr<ViewReader>(std::move(reader));
}

}  // namespace scanmill::formats
