// SPDX-License-Identifier: Apache-2.0
// The header of PCD files (Point Cloud Library, versions .5 to .7).
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/bytes.hpp"
#include "formats/ply_header.hpp"
#include "geom/vec3.hpp"

namespace scanmill::formats {

enum class PcdData { Ascii, Binary, Compressed };

struct PcdField {
  std::string name;
  char type = 'F';           // I, U, F
  std::uint64_t size = 4;    // bytes of one value
  std::uint64_t count = 1;   // values per point
  std::uint64_t offset = 0;  // in a row, bytes
  std::uint64_t word = 0;    // first word in an ascii line
};

struct PcdHeader {
  PcdData data = PcdData::Ascii;
  std::vector<PcdField> fields;
  std::array<std::size_t, 3> xyz{};   // indices of x, y, z in fields
  std::array<PlyType, 3> xyz_type{};  // their types
  std::uint64_t points = 0;
  std::optional<std::uint64_t> cells;   // WIDTH x HEIGHT when it is not POINTS
  bool is_grid = false;                 // WIDTH and HEIGHT both above 1
  std::optional<Vec3> eye;              // from VIEWPOINT
  std::uint64_t stride = 0, words = 0;  // of a row: bytes, words
  std::uint64_t data_offset = 0, data_line = 1;
  std::vector<std::string> notes;
};

/// VIEWPOINT is where the sensor stood; the points are in the file's frame already. 0 0 0 1 0 0 0 is also what programs
/// write that do not know it, so it gives an eye only for organised clouds, which come from one sensor.
/// errors  BadInput with "file:line": a line missing, not numbers, lists of unequal length, no x, y, z
Result<PcdHeader> read_pcd_header(const ByteSource& source);

}  // namespace scanmill::formats
