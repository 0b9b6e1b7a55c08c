// SPDX-License-Identifier: Apache-2.0
// Text files of points as blocks of about 1 MiB. One pass at opening finds where lines begin and counts them; the
// numbers are read when a block is asked for, by any thread.
#include <algorithm>
#include <cstring>

#include "formats/cursor.hpp"
#include "formats/readers.hpp"
#include "formats/text_columns.hpp"

namespace scanmill::formats {
namespace {

constexpr std::uint64_t kChunk = 1 << 20;
constexpr std::size_t kStart = 1 << 16;  // what is looked at to find the columns

struct Run {
  std::uint64_t offset = 0;  // of its first line
  std::uint64_t line = 1;    // number of that line
  std::uint64_t rows = 0;    // data lines in it
};

/// Most lines begin with a number; only the others need a look.
bool is_data_line(std::string_view line) {
  return (!line.empty() && ((line[0] >= '0' && line[0] <= '9') || line[0] == '-')) || !is_comment_or_blank(line);
}

/// One pass over the lines behind the header.
Result<std::vector<Run>> index_lines(const ByteSource& source, std::uint64_t offset, std::uint64_t line) {
  std::vector<Run> runs{{offset, line, 0}};
  Cursor cursor(source, offset, kChunk);
  while (!cursor.at_end()) {
    const std::uint64_t at = cursor.offset();
    TRY_ASSIGN(const std::string_view text, cursor.line());
    if (text.size() > kMaxLine)
      return fail(Code::BadInput, "the line is longer than 1 MiB; this is no text file of points",
                  line_place(source.name(), line));
    if (at - runs.back().offset >= kChunk) runs.push_back({at, line, 0});
    if (is_data_line(text)) ++runs.back().rows;
    ++line;
  }
  runs.push_back({source.size(), line, 0});
  return runs;
}

const char* find_line_end(const char* p, const char* end) {
  const void* found = p == end ? nullptr : std::memchr(p, '\n', static_cast<std::size_t>(end - p));
  return found != nullptr ? static_cast<const char*>(found) : end;
}

class TextReader final : public ViewReader {
 public:
  TextReader(std::shared_ptr<const ByteSource> source, TextStart start, std::vector<Run> runs)
      : source_(std::move(source)), columns_(start.columns), runs_(std::move(runs)) {
    header_.format = "text";
    header_.row_meaning = RowMeaning::LineFromOne;
    for (const Run& run : runs_) header_.rows += run.rows;
    header_.notes = std::move(start.notes);
  }

  const ViewHeader& header() const override { return header_; }
  std::size_t block_count() const override { return runs_.size() - 1; }

  Result<void> read_block(std::size_t number, PointBlock& out) const override {
    const Run& run = runs_[number];
    thread_local std::vector<char> bytes;
    bytes.resize(static_cast<std::size_t>(runs_[number + 1].offset - run.offset));
    TRY(read_exactly(*source_, run.offset, bytes));
    out.points_read = out.not_finite = out.sensor_invalid = 0;
    out.positions.resize(run.rows);
    out.rows.resize(run.rows);
    std::size_t kept = 0;
    std::uint64_t line_number = run.line;
    const char* const end = bytes.data() + bytes.size();
    for (const char* p = bytes.data(); p != end; ++line_number) {
      Vec3 position;
      const char* rest = columns_.plain ? read_plain(p, end, position) : nullptr;
      const char* from = rest != nullptr ? rest : p;
      const char* const stop = from != end && *from == '\n' ? from : find_line_end(from, end);
      const std::string_view line(p, static_cast<std::size_t>(stop - p));
      p = stop == end ? end : stop + 1;
      if (rest == nullptr && is_comment_or_blank(line) && !has_carriage_return_inside(line)) continue;
      const bool odd = rest == nullptr || has_carriage_return_inside({rest, static_cast<std::size_t>(stop - rest)});
      if (odd) {
        TRY_ASSIGN(position, read_columns(line, columns_, source_->name(), line_number));
      }
      if (out.points_read == run.rows)
        return fail(Code::IoFailed, "the file changed while it was read", line_place(source_->name(), line_number));
      ++out.points_read;
      if (!is_finite(position)) {
        ++out.not_finite;
        continue;
      }
      out.positions[kept] = position;
      out.rows[kept++] = line_number;
    }
    out.positions.resize(kept);
    out.rows.resize(kept);
    return {};
  }

 private:
  std::shared_ptr<const ByteSource> source_;
  TextColumns columns_;
  std::vector<Run> runs_;
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
  TRY_ASSIGN(std::vector<Run> runs, index_lines(*source, start.data_offset, start.data_line));
  auto reader = std::make_unique<TextReader>(source, start, std::move(runs));
  if (start.declared_points && *start.declared_points != reader->header().rows)
    return fail(Code::BadInput,
                "the first line declares " + std::to_string(*start.declared_points) + " points, the file holds " +
                    std::to_string(reader->header().rows) + " lines of numbers; it was cut or the count is wrong",
                source->name());
  return std::unique_ptr<ViewReader>(std::move(reader));
}

}  // namespace scanmill::formats
