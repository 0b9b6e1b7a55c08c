// SPDX-License-Identifier: Apache-2.0
// Files of points as streams of blocks.
#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "base/bytes.hpp"
#include "cloud/cloud.hpp"

namespace scanmill::formats {

/// What a row number of a file counts.
enum class RowMeaning { VertexFromZero, LineFromOne };

struct ViewHeader {
  std::string format;  // "ply ascii", "ply binary_little_endian", "xyz", ...
  RowMeaning row_meaning = RowMeaning::VertexFromZero;
  std::uint64_t rows = 0;          // vertices declared, or data lines counted
  bool has_faces = false;          // a mesh, so no scan unless asked
  bool has_grid = false;           // organised rows and columns (range_grid)
  std::vector<std::string> notes;  // what was skipped or repaired, one sentence each
};

/// One file, opened: the header has been read and checked against the file's size. Blocks are read by any thread, in
/// any order, again and again. Positions are as the file gives them: its units, its frame.
class ViewReader {
 public:
  virtual ~ViewReader() = default;
  virtual const ViewHeader& header() const = 0;
  virtual std::size_t block_count() const = 0;
  /// Fills positions, rows and the counts of `out`; leaves view and view_point alone.
  /// errors  BadInput naming the file and the byte or line
  virtual Result<void> read_block(std::size_t number, PointBlock& out) const = 0;
};

/// Opens by content first, by suffix where content does not tell. Fixed memory, whatever the header claims.
/// errors  BadInput naming file and place; Unsupported for a known format that this version does not read
Result<std::unique_ptr<ViewReader>> open_view(std::shared_ptr<const ByteSource> source);

}  // namespace scanmill::formats
