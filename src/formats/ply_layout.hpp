// SPDX-License-Identifier: Apache-2.0
// Where the rows of each element of a PLY file lie, found by one pass over the bytes (none where rows have a fixed
// size).
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "formats/cursor.hpp"
#include "formats/ply_header.hpp"

namespace scanmill::formats {

/// A run of rows that is read as one block.
struct PlyRun {
  std::uint64_t offset = 0;  // of the first row
  std::uint64_t row = 0;     // number of the first row in its element
  std::uint64_t line = 0;    // ascii: number of its line
};

struct PlyLayout {
  std::vector<PlyRun> runs;  // of the wanted element, one more than blocks: the last one is the end
  std::vector<std::string> notes;
};

/// Finds the rows of element number `wanted` and checks that the file holds what the header declares, to the last
/// element.
/// errors  BadInput with "file: byte N" or "file:line" where the file ends too early
Result<PlyLayout> find_rows(const ByteSource& source, const PlyHeader& header, std::size_t wanted);

/// Rows of a fixed-size element per run: 16384 (a block then stays in the second cache), fewer when rows are so long
/// that a block would pass 16 MiB.
std::uint64_t rows_per_run(const PlyElement& element);

/// Moves the cursor over one property of a binary row, list or not.
/// errors  BadInput when the file ends there or a list has a negative length
Result<void> skip_property(Cursor& cursor, const ByteSource& source, const PlyHeader& header, const PlyElement& element,
                           const PlyProperty& property, std::uint64_t row);
/// Moves the cursor over one binary row with lists.
Result<void> skip_row(Cursor& cursor, const ByteSource& source, const PlyHeader& header, const PlyElement& element,
                      std::uint64_t row);

}  // namespace scanmill::formats
