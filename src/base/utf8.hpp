// SPDX-License-Identifier: Apache-2.0
// Text of unknown origin made fit to be shown: names of files are bytes, not words.
#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace scanmill {

/// Length of the well-formed UTF-8 sequence that begins at byte `at`, 0 when there is none; its character in `value`.
std::size_t utf8_sequence(std::string_view text, std::size_t at, std::uint32_t& value);

/// UTF-8 in which nothing is hidden: control characters and bytes that are no UTF-8 become \xNN; invisible and
/// direction marks and non-characters \u{NNNN}. With `keep_lines`, line feeds and tabs stay as they are.
std::string printable(std::string_view text, bool keep_lines = false);

}  // namespace scanmill
