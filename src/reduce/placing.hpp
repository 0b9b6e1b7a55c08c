// SPDX-License-Identifier: Apache-2.0
// The innermost loops of binning: where points lie, and the sums over them. Internal to `reduce`.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "lattice/bin_index.hpp"

namespace scanmill::reduce {

/// Smallest box around the points.
Bounds box_of(std::span<const Vec3> points);

/// A tile of points cut into runs: points one after the other that lie in the same bin. Scanned points come in lines,
/// so a run has several, and a bin is looked up once for all of them. A tile stays in the first cache.
struct Placed {
  static constexpr std::size_t kTile = 256;
  // Per point.
  alignas(64) std::array<double, kTile> score;             // squared distance from the bin's centre, in bin edges
  alignas(64) std::array<std::uint32_t, 2 * kTile> steps;  // four int16: x, y, z about the centre in h/1024; 1
  // Per run.
  std::size_t runs = 0;
  std::array<std::uint32_t, kTile + 1> first;  // its first point; first[runs] is the number of points
  std::array<LocalBin, kTile + 1> bins;
  std::array<std::int32_t, kTile> slots;
  // Between the loops.
  alignas(64) std::array<double, kTile> inside[3];  // in bin edges about the bin's centre, [-1/2, 1/2)
  alignas(64) std::array<std::int32_t, kTile> bin[3];
  alignas(64) std::array<std::uint8_t, kTile> starts;
};

/// Fills everything but `slots`. `steps` are floor(inside 1024 + 1/2). Every value is the one the plain formulas give,
/// to the last bit, whatever vector instructions the processor has. points    at most kTile, all less than 2^30 bins
/// from the base
void place(const Lattice& lattice, const BinKey& base, std::span<const Vec3> points, Placed& placed);
/// The same without wider instructions, for the test that compares them.
void place_plain(const Lattice& lattice, const BinKey& base, std::span<const Vec3> points, Placed& placed);

/// Sums of whole numbers below 2^53 in doubles: exact, so they commute like integers and cost half.
struct alignas(16) WholeSums {
  double xx = 0, yy = 0, zz = 0, count = 0, xy = 0, yz = 0, xz = 0, z = 0, x = 0, y = 0;
  /// Adds the points from `begin` to `end` of a tile.
  void add(const Placed& placed, std::size_t begin, std::size_t end);
  void add(const WholeSums& other);
};

}  // namespace scanmill::reduce
