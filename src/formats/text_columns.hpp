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
#include "geom/vec3.hpp"

namespace scanmill::formats {

/// Words of a line between blanks, tabs, commas and semicolons, quotes removed; two commas in a row hold an empty word.
std::vector<std::string_view> columns_of(std::string_view line);
/// Blank lines and those that begin with # // ; ! %.
bool is_comment_or_blank(std::string_view line);

/// Columns of x, y, z, counted from 0.
struct TextColumns {
  std::array<std::uint32_t, 3> xyz{0, 1, 2};
  std::array<std::uint32_t, 3> ascending{0, 1, 2};
  bool plain = true;  // 0, 1, 2
};

struct TextStart {
  TextColumns columns;
  std::optional<std::uint64_t> declared_points;  // a first line with one whole number
  std::uint64_t data_offset = 0;                 // of the first line behind the header lines
  std::uint64_t data_line = 1;                   // its number
  bool has_data = false;                         // a data line was found in what was looked at
  std::vector<std::string> notes;
};

/// Judges the beginning of a text file. `text` is its first bytes; `complete` when that is all of it (otherwise the
/// last line may be cut and is left out).
/// errors  BadInput with "file:line": no line with three numbers, a header that names x and y but no z, decimal commas,
///         UTF-16, line ends that are a carriage return alone
Result<TextStart> judge_start(std::string_view text, bool complete, const std::string& name);

/// One data line.
/// errors  BadInput: `file:line: found "...", wanted three numbers`
Result<Vec3> read_columns(std::string_view line, const TextColumns& columns, const std::string& name,
                          std::uint64_t number);

/// The common case, x, y, z first, at `p`: the first byte behind z (a blank, a separator, a line end or `end`), or
/// nullptr where read_columns must look. Never passes over a line end.
const char* read_plain(const char* p, const char* end, Vec3& position);

/// A carriage return that is not at the end: one line to us, several to whoever wrote it.
bool has_carriage_return_inside(std::string_view line);

}  // namespace scanmill::formats
