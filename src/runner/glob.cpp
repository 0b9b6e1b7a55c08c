// SPDX-License-Identifier: Apache-2.0
#include "runner/glob.hpp"

#include <algorithm>

#include "base/text.hpp"

namespace scanmill::runner {

bool matches(std::string_view pattern, std::string_view name) { return matches_pattern(pattern, name); }

bool matches_any(std::span<const std::string> patterns, std::string_view name) {
  return patterns.empty() || std::any_of(patterns.begin(), patterns.end(),
                                         [&](const std::string& pattern) { return matches(pattern, name); });
}

}  // namespace scanmill::runner
