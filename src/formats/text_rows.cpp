// SPDX-License-Identifier: Apache-2.0
#include "formats/text_rows.hpp"

#include <cstring>

namespace scanmill::formats {
namespace {

const char* find_line_end(const char* p, const char* end) {
  const void* found = p == end ? nullptr : std::memchr(p, '\n', static_cast<std::size_t>(end - p));
  return found != nullptr ? static_cast<const char*>(found) : end;
}

}  // namespace

Result<void> read_text_run(const ByteSource& source, const TextRun& run, const TextColumns& columns, bool zero_is_empty,
                           PointBlock& out) {
  thread_local std::vector<char> bytes;
  bytes.resize(static_cast<std::size_t>(run.end - run.offset));
  TRY(read_exactly(source, run.offset, bytes));
  out.points_read = out.not_finite = out.sensor_invalid = 0;
  out.positions.resize(run.rows);
  out.rows.resize(run.rows);
  std::size_t kept = 0;
  std::uint64_t line_number = run.line;
  const char* const end = bytes.data() + bytes.size();
  for (const char* p = bytes.data(); p != end; ++line_number) {
    Vec3 position;
    const char* rest = columns.plain ? read_plain(p, end, position) : nullptr;
    const char* from = rest != nullptr ? rest : p;
    const char* const stop = from != end && *from == '\n' ? from : find_line_end(from, end);
    const std::string_view line(p, static_cast<std::size_t>(stop - p));
    p = stop == end ? end : stop + 1;
    if (rest == nullptr && is_comment_or_blank(line) && !has_carriage_return_inside(line)) continue;
    const bool odd = rest == nullptr || has_carriage_return_inside({rest, static_cast<std::size_t>(stop - rest)});
    if (odd) {
      TRY_ASSIGN(position, read_columns(line, columns, source.name(), line_number));
    }
    if (out.points_read == run.rows)
      return fail(Code::IoFailed, "the file changed while it was read", line_place(source.name(), line_number));
    ++out.points_read;
    if (!is_finite(position)) {
      ++out.not_finite;
      continue;
    }
    if (zero_is_empty && position == Vec3{}) {
      ++out.sensor_invalid;
      continue;
    }
    out.positions[kept] = position;
    out.rows[kept++] = line_number;
  }
  out.positions.resize(kept);
  out.rows.resize(kept);
  return {};
}

}  // namespace scanmill::formats
