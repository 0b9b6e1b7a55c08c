// SPDX-License-Identifier: Apache-2.0
// Rows of fixed size to positions: the inner loop of reading.
#pragma once
#include <cstdint>
#include <vector>

#include "formats/ply_header.hpp"
#include "geom/vec3.hpp"

namespace scanmill::formats {

struct Coordinate {
  PlyType type = PlyType::Float32;
  std::uint64_t offset = 0;  // in the row
};

/// positions[i] = (x, y, z) of row i of `rows`, whose bytes begin at `bytes`.
/// returns  whether all of them are finite
bool decode_positions(const char* bytes, std::uint64_t stride, const Coordinate (&xyz)[3], bool swap, std::size_t rows,
                      Vec3* positions);

/// Removes positions that are not finite with their row numbers, keeping order; returns how many went.
std::uint64_t drop_not_finite(std::vector<Vec3>& positions, std::vector<std::uint64_t>& rows);

}  // namespace scanmill::formats
