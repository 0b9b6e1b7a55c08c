// SPDX-License-Identifier: Apache-2.0
#include "formats/ply_layout.hpp"

#include <algorithm>

namespace scanmill::formats {
namespace {

constexpr std::uint64_t kRunRows = 16384;
constexpr std::uint64_t kRunBytes = 4 << 20;  // of rows without a fixed size

bool is_blank(std::string_view line) { return line.find_first_not_of(" \t\r") == std::string_view::npos; }

Error too_short(const ByteSource& source, const PlyElement& element, std::uint64_t rows) {
  return fail(Code::BadInput,
              "the header declares " + std::to_string(element.count) + " rows of element " + quoted(element.name) +
                  ", the file ends after " + std::to_string(rows) + "; it was cut or its header is wrong",
              byte_place(source.name(), source.size()));
}

/// Collects the starts of runs while an index pass walks over rows.
class RunIndex {
 public:
  explicit RunIndex(std::vector<PlyRun>& runs) : runs_(runs) {}
  void row_begins(std::uint64_t offset, std::uint64_t row, std::uint64_t line) {
    if (runs_.empty() || row - runs_.back().row >= kRunRows || offset - runs_.back().offset >= kRunBytes)
      runs_.push_back({offset, row, line});
  }
  void end(std::uint64_t offset, std::uint64_t row, std::uint64_t line) { runs_.push_back({offset, row, line}); }

 private:
  std::vector<PlyRun>& runs_;
};

class Pass {
 public:
  Pass(const ByteSource& source, const PlyHeader& header, std::size_t wanted)
      : source_(source),
        header_(header),
        wanted_(wanted),
        cursor_(source, header.data_offset),
        line_(header.data_line) {}

  Result<PlyLayout> run() {
    for (std::size_t i = 0; i < header_.elements.size(); ++i) {
      const PlyElement& element = header_.elements[i];
      if (header_.encoding == PlyEncoding::Ascii)
        TRY(pass_lines(element, i == wanted_));
      else if (element.has_lists)
        TRY(pass_lists(element, i == wanted_));
      else
        TRY(pass_fixed(element, i == wanted_));
    }
    TRY(look_behind());
    return std::move(layout_);
  }

 private:
  Result<void> pass_fixed(const PlyElement& element, bool wanted) {
    const std::uint64_t begin = cursor_.offset(), left = source_.size() - std::min(source_.size(), begin);
    if (element.stride > 0 && element.count > left / element.stride)
      return too_short(source_, element, left / element.stride);
    if (wanted) {
      const std::uint64_t step = rows_per_run(element);
      for (std::uint64_t row = 0; row < element.count; row += step)
        layout_.runs.push_back({begin + row * element.stride, row, 0});
      layout_.runs.push_back({begin + element.count * element.stride, element.count, 0});
    }
    cursor_.skip(element.count * element.stride);
    return {};
  }

  Result<void> pass_lists(const PlyElement& element, bool wanted) {
    RunIndex index(layout_.runs);
    for (std::uint64_t row = 0; row < element.count; ++row) {
      if (wanted) index.row_begins(cursor_.offset(), row, 0);
      TRY(skip_row(cursor_, source_, header_, element, row));
    }
    if (wanted) index.end(cursor_.offset(), element.count, 0);
    return {};
  }

  Result<void> pass_lines(const PlyElement& element, bool wanted) {
    RunIndex index(layout_.runs);
    for (std::uint64_t row = 0; row < element.count;) {
      if (cursor_.at_end()) return too_short(source_, element, row);
      const std::uint64_t offset = cursor_.offset();
      std::string_view text;
      if (!cursor_.line_at_hand(text)) {
        TRY_ASSIGN(text, cursor_.line());
      }
      const std::uint64_t line = line_++;
      if (is_blank(text)) continue;
      if (wanted) index.row_begins(offset, row, line);
      ++row;
    }
    if (wanted) index.end(cursor_.offset(), element.count, line_);
    return {};
  }

  Result<void> look_behind() {
    const std::uint64_t end = cursor_.offset();
    if (header_.encoding == PlyEncoding::Ascii) {
      while (!cursor_.at_end()) {
        const std::uint64_t offset = cursor_.offset();
        TRY_ASSIGN(const std::string_view text, cursor_.line());
        const std::uint64_t line = line_++;
        if (is_blank(text)) continue;
        if (rows_declared()) return goes_on(source_.size() - offset, line_place(source_.name(), line));
        return note_rest(offset);
      }
      return {};
    }
    const std::uint64_t rest = source_.size() - std::min(source_.size(), end);
    if (rows_declared() && rest >= least_row(header_.elements.back()))
      return goes_on(rest, byte_place(source_.name(), end));
    if (rest > 0) return note_rest(end);
    return {};
  }

  bool rows_declared() const { return !header_.elements.empty(); }

  /// Bytes of the shortest binary row of an element.
  static std::uint64_t least_row(const PlyElement& element) {
    std::uint64_t bytes = 0;
    for (const PlyProperty& property : element.properties)
      bytes += size_of(property.is_list ? property.count_type : property.type);
    return std::max<std::uint64_t>(bytes, 1);
  }

  /// What stands there would be lost unseen.
  Result<void> goes_on(std::uint64_t bytes, std::string place) const {
    const PlyElement& last = header_.elements.back();
    return fail(Code::BadInput,
                "the file goes on for " + std::to_string(bytes) + " bytes behind the " + std::to_string(last.count) +
                    " rows of element " + quoted(last.name) +
                    " that the header declares; correct the count, or cut what does not belong there",
                std::move(place));
  }

  Result<void> note_rest(std::uint64_t offset) {
    layout_.notes.push_back(std::to_string(source_.size() - offset) + " bytes behind the last element (from byte " +
                            std::to_string(offset) + ") were not read");
    return {};
  }

  const ByteSource& source_;
  const PlyHeader& header_;
  std::size_t wanted_;
  Cursor cursor_;
  std::uint64_t line_;
  PlyLayout layout_;
};

}  // namespace

Result<PlyLayout> find_rows(const ByteSource& source, const PlyHeader& header, std::size_t wanted) {
  return Pass(source, header, wanted).run();
}

std::uint64_t rows_per_run(const PlyElement& element) {
  constexpr std::uint64_t kBlockBytes = 16 << 20;
  return std::clamp<std::uint64_t>(kBlockBytes / std::max<std::uint64_t>(element.stride, 1), 1, kRunRows);
}

Result<void> skip_property(Cursor& cursor, const ByteSource& source, const PlyHeader& header, const PlyElement& element,
                           const PlyProperty& property, std::uint64_t row) {
  std::uint64_t bytes = size_of(property.type);
  if (property.is_list) {
    const std::size_t head = size_of(property.count_type);
    TRY_ASSIGN(const std::string_view count_bytes, cursor.peek(head));
    if (count_bytes.size() < head) return too_short(source, element, row);
    const double count = load_value(property.count_type, header.swaps_bytes(), count_bytes.data());
    if (count < 0)
      return fail(Code::BadInput,
                  "a list of row " + std::to_string(row) + " of element " + quoted(element.name) + " has the length " +
                      std::to_string(static_cast<std::int64_t>(count)) + "; wanted 0 or more",
                  byte_place(source.name(), cursor.offset()));
    cursor.skip(head);
    bytes *= static_cast<std::uint64_t>(count);
  }
  if (bytes > source.size() - cursor.offset()) return too_short(source, element, row);
  cursor.skip(bytes);
  return {};
}

Result<void> skip_row(Cursor& cursor, const ByteSource& source, const PlyHeader& header, const PlyElement& element,
                      std::uint64_t row) {
  for (const PlyProperty& property : element.properties)
    TRY(skip_property(cursor, source, header, element, property, row));
  return {};
}

}  // namespace scanmill::formats
