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
  // The runs by their length: those of `n` points from of_length[n] on, those of kLong and more at the end.
  static constexpr std::size_t kLong = 9;
  std::array<std::uint16_t, kTile> by_length;
  std::array<std::uint16_t, kLong + 2> of_length;
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
  /// Adds `points` points of a tile, from `begin` on. Fastest where the compiler knows the count.
  void add(const Placed& placed, std::size_t begin, std::size_t points);
  void add(const WholeSums& other);
};

/// Two points in one register as x x y y z z 1 1; a product of pairs of int16 then sums over both. A tile's sums stay
/// below 2^27.
[[gnu::always_inline]] inline void WholeSums::add(const Placed& placed, std::size_t begin, std::size_t points) {
  const std::uint32_t* steps = placed.steps.data() + 2 * begin;
  auto load = [&](std::size_t n) { return _mm_loadl_epi64(reinterpret_cast<const __m128i*>(steps + 2 * n)); };
  const __m128i ones_16 = _mm_set1_epi16(1);
  __m128i squares = _mm_setzero_si128(), mixed = squares, plain = squares;
  auto take = [&](__m128i pair) {
    const __m128i turned = _mm_shuffle_epi32(pair, _MM_SHUFFLE(3, 0, 2, 1));
    squares = _mm_add_epi32(squares, _mm_madd_epi16(pair, pair));  // xx yy zz n
    mixed = _mm_add_epi32(mixed, _mm_madd_epi16(pair, turned));    // xy yz zx n
    plain = _mm_add_epi32(plain, _mm_madd_epi16(pair, ones_16));   // x y z n
  };
  std::size_t n = 0;
  for (; n + 2 <= points; n += 2) take(_mm_unpacklo_epi16(load(n), load(n + 1)));
  if (n < points) take(_mm_unpacklo_epi16(load(n), _mm_setzero_si128()));
  auto low = [](__m128i v) { return _mm_cvtepi32_pd(v); };
  auto high = [](__m128i v) { return _mm_cvtepi32_pd(_mm_shuffle_epi32(v, 0xee)); };
  auto sum = [](double* at, __m128d v) { _mm_store_pd(at, _mm_add_pd(_mm_load_pd(at), v)); };
  sum(&xx, low(squares));
  sum(&zz, high(squares));
  sum(&xy, low(mixed));
  sum(&xz, _mm_unpacklo_pd(high(mixed), high(plain)));
  sum(&x, low(plain));
}

}  // namespace scanmill::reduce
