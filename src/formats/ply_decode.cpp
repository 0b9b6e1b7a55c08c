// SPDX-License-Identifier: Apache-2.0
// Plain loops over arrays without branches, so the compiler can use what vector instructions the base build has.
// Finiteness is judged on the sum of x - x over a row, which is 0 for finite numbers and NaN otherwise.
#include "formats/ply_decode.hpp"

#include <cstring>

#include "base/wide.hpp"

namespace scanmill::formats {
namespace {

static_assert(sizeof(Vec3) == 3 * sizeof(double));

/// Most clouds: nothing but float x, y, z in the machine's byte order.
SCANMILL_WIDE bool decode_packed_floats(const char* bytes, std::size_t count, double* out) {
  constexpr std::uint32_t kExponent = 0x7f800000u;
  std::uint32_t bad = 0;
  for (std::size_t i = 0; i < count; ++i) {
    std::uint32_t word;
    std::memcpy(&word, bytes + i * 4, 4);
    float value;
    std::memcpy(&value, bytes + i * 4, 4);
    bad |= (word & kExponent) == kExponent ? 1u : 0u;
    out[i] = static_cast<double>(value);
  }
  return bad == 0;
}

template <class T>
bool decode_native(const char* bytes, std::uint64_t stride, const Coordinate (&xyz)[3], std::size_t rows,
                   Vec3* positions) {
  double doubt = 0;
  for (std::size_t i = 0; i < rows; ++i) {
    const char* row = bytes + i * stride;
    T x, y, z;
    std::memcpy(&x, row + xyz[0].offset, sizeof(T));
    std::memcpy(&y, row + xyz[1].offset, sizeof(T));
    std::memcpy(&z, row + xyz[2].offset, sizeof(T));
    const Vec3 p{static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)};
    positions[i] = p;
    doubt += (p.x - p.x) + (p.y - p.y) + (p.z - p.z);
  }
  return doubt == 0;
}

bool decode_any(const char* bytes, std::uint64_t stride, const Coordinate (&xyz)[3], bool swap, std::size_t rows,
                Vec3* positions) {
  double doubt = 0;
  for (std::size_t i = 0; i < rows; ++i) {
    const char* row = bytes + i * stride;
    const Vec3 p{load_value(xyz[0].type, swap, row + xyz[0].offset), load_value(xyz[1].type, swap, row + xyz[1].offset),
                 load_value(xyz[2].type, swap, row + xyz[2].offset)};
    positions[i] = p;
    doubt += (p.x - p.x) + (p.y - p.y) + (p.z - p.z);
  }
  return doubt == 0;
}

}  // namespace

bool decode_positions(const char* bytes, std::uint64_t stride, const Coordinate (&xyz)[3], bool swap, std::size_t rows,
                      Vec3* positions) {
  if (rows == 0) return true;
  const bool same = xyz[0].type == xyz[1].type && xyz[1].type == xyz[2].type;
  if (!swap && same && xyz[0].type == PlyType::Float32) {
    if (stride == 12 && xyz[0].offset == 0 && xyz[1].offset == 4 && xyz[2].offset == 8)
      return decode_packed_floats(bytes, rows * 3, &positions[0].x);
    return decode_native<float>(bytes, stride, xyz, rows, positions);
  }
  if (!swap && same && xyz[0].type == PlyType::Float64)
    return decode_native<double>(bytes, stride, xyz, rows, positions);
  return decode_any(bytes, stride, xyz, swap, rows, positions);
}

std::uint64_t drop_not_finite(std::vector<Vec3>& positions, std::vector<std::uint64_t>& rows) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    if (!is_finite(positions[i])) continue;
    positions[kept] = positions[i];
    rows[kept] = rows[i];
    ++kept;
  }
  const std::uint64_t dropped = positions.size() - kept;
  positions.resize(kept);
  rows.resize(kept);
  return dropped;
}

}  // namespace scanmill::formats
