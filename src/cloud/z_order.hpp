// SPDX-License-Identifier: Apache-2.0
// Numbers along the Z-order curve.
#pragma once
#include <cstdint>

namespace scanmill {

inline constexpr int kZOrderBits = 21;  // per axis

/// The low bits of `v` two places apart.
constexpr std::uint64_t spread(std::uint64_t v) {
  v &= (1ull << kZOrderBits) - 1;
  v = (v | v << 32) & 0x1f00000000ffffull;
  v = (v | v << 16) & 0x1f0000ff0000ffull;
  v = (v | v << 8) & 0x100f00f00f00f00full;
  v = (v | v << 4) & 0x10c30c30c30c30c3ull;
  return (v | v << 2) & 0x1249249249249249ull;
}
constexpr std::uint64_t z_order(std::uint64_t x, std::uint64_t y, std::uint64_t z) {
  return spread(x) | spread(y) << 1 | spread(z) << 2;
}

}  // namespace scanmill
