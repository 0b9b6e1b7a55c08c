// SPDX-License-Identifier: Apache-2.0
// Decimal text to the nearest double.
#pragma once

namespace scanmill::formats {

/// Reads one number at `p` (leading '+' allowed; nan, inf and the spellings of old C libraries, 1.#QNAN, too). Returns
/// the first byte behind it, or nullptr when no number stands there. Never reads at or past `end`. The same bits as
/// std::from_chars; beyond the range of double: 0 or infinite.
const char* parse_decimal(const char* p, const char* end, double& value);

}  // namespace scanmill::formats
