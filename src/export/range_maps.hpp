// SPDX-License-Identifier: Apache-2.0
// One view as a rig leaves it, in the formats that view readers take.
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "base/bytes.hpp"
#include "geom/vec3.hpp"

namespace scanmill::exporting {

enum class RangeFormat : std::int32_t { Ply, Xyz, Ptx, Pcd, Png };
/// By value: ply xyz ptx pcd png; they are the files' suffixes too.
std::span<const std::string_view> range_format_words();
std::optional<RangeFormat> range_format_of(std::string_view word);

/// A grid of points in the sensor frame, row by row from the top; cells without return are NaN. Coordinates are float32
/// values in the units of the file.
struct RangeGrid {
  std::int64_t width = 0, height = 0;
  std::span<const Vec3> points;
  double depth_scale = 1;  // PNG: pixel value per unit of z
};

/// PLY and XYZ hold the points that are there, in the order of the grid; PTX (its poses the identity, empty cells
/// 0 0 0, column by column) and PCD (binary, NaN) the whole grid; PNG the depths of a pinhole camera, 16 bits, rounded
/// to whole values, 0 where there is none. What PLY, XYZ, PTX and PCD hold is read back to the same float32, -0 apart.
/// Comments go where the format has room for them (PLY, XYZ, PCD). Does not commit the sink. errors  what the sink
/// reports; BadParameter for a depth that 16 bits do not hold
Result<void> write_range_map(RangeFormat format, const RangeGrid& grid, std::span<const std::string> comments,
                             ByteSink& sink);

}  // namespace scanmill::exporting
