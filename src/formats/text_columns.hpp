// SPDX-License-Identifier: Apache-2.0
// Which columns of a text file hold x, y, z; and one line of such a file.
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.hpp"
#include "formats/text_cells.hpp"
#include "geom/vec3.hpp"

namespace scanmill::formats {

/// Blank lines and those that begin with # // ; ! %.
bool is_comment_or_blank(std::string_view line);

/// Columns of x, y, z, counted from 0.
struct TextColumns {
  std::array<std::uint32_t, 3> xyz{0, 1, 2};
  std::array<std::uint32_t, 3> ascending{0, 1, 2};
  bool plain = true;               // 0, 1, 2
  char separator = kAnySeparator;  // how lines are split (text_cells.hpp)
};

struct TextStart {
  TextColumns columns;
  std::optional<std::uint64_t> declared_points;  // a first line with one whole number
  std::uint64_t data_offset = 0;                 // of the first line behind the header lines
  std::uint64_t data_line = 1;                   // its number
  bool has_data = false;                         // a data line was found in what was looked at
  double mm_per_unit = 0;                        // as the names of the columns say; 0: they do not
  std::vector<std::string> notes;
};

/// Judges the beginning of a text file. `text` is its first bytes; `complete` when that is all of it (otherwise the
/// last line may be cut and is left out). A header line names the columns only when, split as the lines of numbers are,
/// each of x, y, z is the name of exactly one cell; otherwise the first three columns of numbers are taken. The notes
/// say which columns those are unless they are the first three of a file without a header.
/// errors  BadInput with "file:line": no line with three numbers, a header that names x and y but no z or more columns
///         than there are, names with different units, decimal commas, UTF-16, line ends that are a carriage return
///         alone
Result<TextStart> judge_start(std::string_view text, bool complete, const std::string& name);

/// One data line.
/// errors  BadInput: `file:line: found "...", wanted three numbers`; decimal commas
Result<Vec3> read_columns(std::string_view line, const TextColumns& columns, const std::string& name,
                          std::uint64_t number);

/// The common case, x, y, z first, at `p`: the first byte behind z (a blank, a separator, a line end or `end`), or
/// nullptr where read_columns must look, as where the two separators are not of one kind. Never passes over a line end.
const char* read_plain(const char* p, const char* end, Vec3& position);

/// What is said of a line with decimal commas.
Error decimal_commas(std::string_view line, const std::string& name, std::uint64_t number);

/// A carriage return that is not at the end: one line to us, several to whoever wrote it.
bool has_carriage_return_inside(std::string_view line);

}  // namespace scanmill::formats
