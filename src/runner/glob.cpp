// SPDX-License-Identifier: Apache-2.0
#include "runner/glob.hpp"

#include <algorithm>

#include "base/text.hpp"

namespace scanmill::runner {

namespace {

int hex_digit(char c) { return c >= '0' && c <= '9' ? c - '0' : c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1; }

/// "%C3%96lfilter" as the file system shows it.
std::string decoded(std::string_view name) {
  std::string text;
  for (std::size_t i = 0; i < name.size(); ++i) {
    const bool code =
        name[i] == '%' && i + 2 < name.size() && hex_digit(name[i + 1]) >= 0 && hex_digit(name[i + 2]) >= 0;
    text += code ? static_cast<char>(16 * hex_digit(name[i + 1]) + hex_digit(name[i + 2])) : name[i];
    if (code) i += 2;
  }
  return text;
}

}  // namespace

bool matches(std::string_view pattern, std::string_view name) {
  return matches_pattern(pattern, name) ||
         (name.find('%') != std::string_view::npos && matches_pattern(pattern, decoded(name)));
}

bool matches_any(std::span<const std::string> patterns, std::string_view name) {
  return patterns.empty() || std::any_of(patterns.begin(), patterns.end(),
                                         [&](const std::string& pattern) { return matches(pattern, name); });
}

}  // namespace scanmill::runner
