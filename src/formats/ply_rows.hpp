// SPDX-License-Identifier: Apache-2.0
// Chosen scalar properties out of rows that have no fixed size: ascii lines, binary rows with lists.
#pragma once
#include <span>

#include "formats/cursor.hpp"
#include "formats/ply_header.hpp"
#include "formats/ply_layout.hpp"

namespace scanmill::formats {

/// Values of one line in the order of `wanted` (indices of scalar properties, ascending). The line must hold exactly
/// the values the header declares.
/// errors  BadInput with "name:line_number" as place
Result<void> read_ascii_row(std::string_view line, const PlyElement& element, std::span<const int> wanted,
                            std::span<double> values, const std::string& name, std::uint64_t line_number);

/// The same for a binary row; the cursor moves behind it.
Result<void> read_binary_row(Cursor& cursor, const ByteSource& source, const PlyHeader& header,
                             const PlyElement& element, std::span<const int> wanted, std::span<double> values,
                             std::uint64_t row);

}  // namespace scanmill::formats
