// SPDX-License-Identifier: Apache-2.0
// The local Delaunay star of a point in its tangent plane. Internal to `stars`.
#pragma once
#include <array>
#include <bit>
#include <vector>

#include "stars/parts.hpp"

namespace scanmill::stars {

/// Neighbours in counter-clockwise order about the point's normal; gap[k]: no triangle between vertex[k] and
/// vertex[k + 1].
struct Star {
  static constexpr int kMax = 16;
  std::array<std::uint32_t, kMax> vertex{};
  std::uint32_t gaps = 0;  // bit k
  std::uint8_t size = 0;

  bool gap(int k) const { return (gaps >> k) & 1; }
  /// +1: the star holds triangle (centre, a, b) in this sense; -1: (centre, b, a); 0: neither.
  int direction(std::uint32_t a, std::uint32_t b) const {
    unsigned found = 0;  // no branch in the search: the place is anybody's guess
    for (unsigned k = 0; k < kMax; ++k) found |= static_cast<unsigned>(vertex[k] == a) << k;
    found &= (1u << size) - 1;
    if (found == 0) return 0;
    const int k = std::countr_zero(found), next = k + 1 < size ? k + 1 : 0, last = k > 0 ? k - 1 : size - 1;
    if (vertex[static_cast<std::size_t>(next)] == b && !gap(k)) return 1;
    if (vertex[static_cast<std::size_t>(last)] == b && !gap(last)) return -1;
    return 0;
  }
};

/// Stars of all kept rows (empty for the others), or of those whose `role` (stars/parts.hpp) asks for one. Adds to
/// `refused.range` the star edges, of a part's own rows, that only g1 on measured coordinates turned into gaps.
std::vector<Star> stars_of(const SurfacePoints& points, std::span<const Role> roles, const Params& params,
                           RefusalCounts& refused, const Context& context);

}  // namespace scanmill::stars
