// SPDX-License-Identifier: Apache-2.0
// Numbers as text, the same bytes everywhere, and the nearest name for a misspelt one.
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace scanmill {

/// Shortest decimal text that reads back to the same double ("inf", "nan" included).
std::string number_text(double value);
/// 1234567 as "1,234,567".
std::string grouped(std::uint64_t value);
/// 1536 as "1.5 KiB".
std::string bytes_text(std::uint64_t bytes);
/// "512M", "2G", "1.5GiB", "4096": binary units. Nothing when the text is not a size.
std::optional<std::uint64_t> parse_size(std::string_view text);
/// Whole text as a number; nothing otherwise. Accepts a leading '+'.
std::optional<double> parse_number(std::string_view text);
/// The candidate with the least edit distance (at most half the word's length), or empty.
std::string_view nearest_name(std::string_view word, std::span<const std::string_view> candidates);

}  // namespace scanmill
