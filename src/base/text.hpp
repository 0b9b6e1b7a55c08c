// SPDX-License-Identifier: Apache-2.0
// Numbers as text, the same bytes everywhere; words, lines and paths in a text; the nearest name for a misspelt one.
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace scanmill {

/// Shortest decimal text that reads back to the same double ("inf", "nan" included).
std::string number_text(double value);
/// Six significant digits, for people.
std::string six_digits(double value);
/// 1234567 as "1,234,567".
std::string grouped(std::uint64_t value);
/// "1 scan", "1,234 scans".
std::string counted(std::uint64_t count, std::string_view thing);
/// 1536 as "1.5 KiB".
std::string bytes_text(std::uint64_t bytes);
/// "512M", "2G", "1.5GiB", "4096": binary units. Nothing when the text is not a size.
std::optional<std::uint64_t> parse_size(std::string_view text);
/// Whole text as a number; nothing otherwise. Accepts one leading '+'.
std::optional<double> parse_number(std::string_view text);
/// The candidate with the least edit distance (less than half the word), else the first that begins
/// with the word, else empty.
std::string_view nearest_name(std::string_view word, std::span<const std::string_view> candidates);
/// `*` in the pattern stands for any run of characters ('/' included), `?` for one; a name matches itself.
bool matches_pattern(std::string_view pattern, std::string_view name);
/// What stands between blanks, tabs and carriage returns; views into `line`.
std::vector<std::string_view> words_of(std::string_view line);
/// What stands between line feeds, at least one (empty) line.
std::vector<std::string> lines_of(std::string_view text);
/// Whether a relative path stays below the folder it is relative to: no "..", not absolute, not empty. Archives are not
/// trusted.
bool is_inside(std::string_view path);

}  // namespace scanmill
