// SPDX-License-Identifier: Apache-2.0
// The innermost loops of binning: where points lie, and the sums over them. Internal to `reduce`.
#pragma once
#include <emmintrin.h>

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

/// What the first pass adds up, per run of a tile.
struct RunSums {
  /// Sums over the points of the tile that stand before a run: xx yy zz n, xy yz zx n, x y z n, four free. Those of a
  /// run are the difference to the next, and no loop ends where nobody can guess. They stay below 2^27.
  using Sums = std::array<std::int32_t, 16>;
  alignas(64) std::array<Sums, Placed::kTile + 1> before;
  std::array<double, Placed::kTile + 1> least_before;  // score in the run before
  double least(std::size_t run) const { return least_before[run + 1]; }
};
void sum_runs(const Placed& placed, RunSums& sums);
/// The same without wider instructions, for the test that compares them.
void sum_runs_plain(const Placed& placed, RunSums& sums);

/// Sums of whole numbers below 2^53 in doubles: exact, so they commute like integers and cost half.
struct alignas(16) WholeSums {
  double xx = 0, yy = 0, zz = 0, count = 0, xy = 0, yz = 0, xz = 0, z = 0, x = 0, y = 0;
  void add(const RunSums& sums, std::size_t run);
  void add(const WholeSums& other);
};

[[gnu::always_inline]] inline void WholeSums::add(const RunSums& sums, std::size_t run) {
  auto difference = [&](std::size_t from) {
    auto load = [&](std::size_t n) { return _mm_load_si128(reinterpret_cast<const __m128i*>(&sums.before[n][from])); };
    return _mm_sub_epi32(load(run + 1), load(run));
  };
  const __m128i squares = difference(0), mixed = difference(4), plain = difference(8);
  auto low = [](__m128i v) { return _mm_cvtepi32_pd(v); };
  auto high = [](__m128i v) { return _mm_cvtepi32_pd(_mm_shuffle_epi32(v, 0xee)); };
  auto sum = [](double* at, __m128d v) { _mm_store_pd(at, _mm_add_pd(_mm_load_pd(at), v)); };
  sum(&xx, low(squares));
  sum(&zz, high(squares));
  sum(&xy, low(mixed));
  sum(&xz, low(_mm_unpackhi_epi32(mixed, plain)));
  sum(&x, low(plain));
}

}  // namespace scanmill::reduce
