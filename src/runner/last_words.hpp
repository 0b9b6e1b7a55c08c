// SPDX-License-Identifier: Apache-2.0
// What a program that failed had to say.
#pragma once
#include <cstdint>
#include <string>

namespace scanmill::runner {

/// The last lines of a log that are not blank, printable and on one line; `begin`: the byte from which on they count.
std::string last_words(const std::string& log, std::uint64_t begin, std::size_t count);

}  // namespace scanmill::runner
