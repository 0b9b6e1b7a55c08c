// SPDX-License-Identifier: Apache-2.0
// The job's bin lattice and the keys of its bins.
#pragma once
#include <array>
#include <cmath>
#include <cstdint>

#include "geom/vec3.hpp"

namespace scanmill {

/// Edge and origin for the whole job; never anchored at the points at hand unless the job says `origin: bounds`.
struct Lattice {
  double edge_mm = 1;  // h
  Vec3 origin;
};

/// A bin (i, j, k) = floor((p - origin) / h).
///
/// Keys are ordered along the Z-order curve of the three numbers, so any brick whose edge is a power of two (and that
/// stands on a multiple of it) is one run of keys: bricks of every size agree on the order of vertices.
struct BinKey {
  std::int64_t i = 0, j = 0, k = 0;
  friend constexpr bool operator==(const BinKey&, const BinKey&) = default;
};

/// True when a stands before b on the Z-order curve (k is the most significant axis, then j, then i).
constexpr bool before(const BinKey& a, const BinKey& b) {
  constexpr std::uint64_t kBias = 0x8000000000000000ull;
  const std::uint64_t x[3] = {(static_cast<std::uint64_t>(a.k) ^ kBias) ^ (static_cast<std::uint64_t>(b.k) ^ kBias),
                              (static_cast<std::uint64_t>(a.j) ^ kBias) ^ (static_cast<std::uint64_t>(b.j) ^ kBias),
                              (static_cast<std::uint64_t>(a.i) ^ kBias) ^ (static_cast<std::uint64_t>(b.i) ^ kBias)};
  int axis = 0;
  for (int candidate = 1; candidate < 3; ++candidate)  // the axis whose highest differing bit is the highest
    if (x[axis] < x[candidate] && x[axis] < (x[axis] ^ x[candidate])) axis = candidate;
  if (axis == 0) return a.k < b.k;
  if (axis == 1) return a.j < b.j;
  return a.i < b.i;
}

inline BinKey bin_of(const Lattice& lattice, Vec3 p) {
  return {static_cast<std::int64_t>(std::floor((p.x - lattice.origin.x) / lattice.edge_mm)),
          static_cast<std::int64_t>(std::floor((p.y - lattice.origin.y) / lattice.edge_mm)),
          static_cast<std::int64_t>(std::floor((p.z - lattice.origin.z) / lattice.edge_mm))};
}

inline Vec3 centre_of(const Lattice& lattice, const BinKey& bin) {
  return lattice.origin + Vec3{(static_cast<double>(bin.i) + 0.5) * lattice.edge_mm,
                               (static_cast<double>(bin.j) + 0.5) * lattice.edge_mm,
                               (static_cast<double>(bin.k) + 0.5) * lattice.edge_mm};
}

}  // namespace scanmill
