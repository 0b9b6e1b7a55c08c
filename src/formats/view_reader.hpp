// SPDX-License-Identifier: Apache-2.0
// Files of points as streams of blocks.
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/bytes.hpp"
#include "cloud/cloud.hpp"
#include "geom/pose.hpp"

namespace scanmill::formats {

/// What a row number of a file counts.
enum class RowMeaning { VertexFromZero, LineFromOne, PointFromZero, PixelFromZero };
/// "vertex from 0", "line from 1", "point from 0", "pixel from 0" (row of the image * width + column).
const char* name_of(RowMeaning meaning);

struct ViewHeader {
  std::string format;  // "ply ascii", "ply binary_little_endian", "xyz", ...
  RowMeaning row_meaning = RowMeaning::VertexFromZero;
  std::uint64_t rows = 0;          // vertices declared, or data lines counted
  bool has_faces = false;          // a mesh, so no scan unless asked
  bool has_grid = false;           // organised rows and columns (range_grid)
  double mm_per_unit = 0;          // what the file says of its units; 0: nothing
  std::vector<std::string> notes;  // what was skipped or repaired, one sentence each
  Pose pose;                       // view frame -> frame of the file (PTX); translation in the file's units
  ViewPoint view_point;            // in the view frame, in the file's units, as far as the file tells
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

/// Formats of points by name; Auto judges by content first, by suffix where content does not tell.
enum class Format : std::int32_t { Auto, Ply, Text, Pts, Ptx, Pcd, Las, Png, Fringes };
std::span<const std::string_view> format_words();

/// A pinhole camera looking along +z; pixel (u, v) of depth z is x = (u - cx) z / fx, y = (v - cy) z / fy.
struct DepthCamera {
  double fx = 0, fy = 0, cx = 0, cy = 0;  // pixels
  double depth_scale = 1000;              // z = value / depth_scale, in the units of the input
  friend bool operator==(const DepthCamera&, const DepthCamera&) = default;
};

/// What a file does not say itself.
struct OpenOptions {
  Format format = Format::Auto;
  std::optional<DepthCamera> camera;  // depth maps need it
  /// A file by its name in the folder of the source; fringe descriptions need it.
  std::function<Result<std::shared_ptr<const ByteSource>>(const std::string& name)> open_beside = {};
};

/// One reader per scan of the file, in file order: a PTX may hold several, all others hold one. Fixed memory (and what
/// a reader says about itself), whatever the header claims.
/// errors  BadInput naming file and place; Unsupported for a known format that this version does not read
Result<std::vector<std::unique_ptr<ViewReader>>> open_views(std::shared_ptr<const ByteSource> source,
                                                            const OpenOptions& options = {});
/// The same for files of one scan.
/// errors  also BadInput where the file holds several
Result<std::unique_ptr<ViewReader>> open_view(std::shared_ptr<const ByteSource> source,
                                              const OpenOptions& options = {});

}  // namespace scanmill::formats
