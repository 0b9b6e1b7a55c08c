// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <span>
#include <string>
#include <string_view>

namespace scanmill::runner {

/// `*` stands for any run of characters ('/' included), `?` for one; a name matches itself,
/// with its %-codes or as the files are called.
bool matches(std::string_view pattern, std::string_view name);
/// True when one of the patterns matches; an empty list matches everything.
bool matches_any(std::span<const std::string> patterns, std::string_view name);

}  // namespace scanmill::runner
