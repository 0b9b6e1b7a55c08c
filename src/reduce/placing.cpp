// SPDX-License-Identifier: Apache-2.0
#include "reduce/placing.hpp"

#include <immintrin.h>

#include <algorithm>
#include <bit>
#include <cstring>

#include "base/wide.hpp"

namespace scanmill::reduce {
namespace {

static_assert(sizeof(Vec3) == 3 * sizeof(double) && sizeof(LocalBin) == 3 * sizeof(std::int32_t));

/// Points whose coordinates fill whole registers of every width: lanes are x y z x y z ...
constexpr std::size_t kAtOnce = 8, kLanes = 3 * kAtOnce;

SCANMILL_WIDE void extremes(const double* p, std::size_t rounds, double* low, double* high) {
  double least[kLanes], greatest[kLanes];
  for (std::size_t lane = 0; lane < kLanes; ++lane) least[lane] = greatest[lane] = rounds > 0 ? p[lane] : 0;
  for (std::size_t round = 1; round < rounds; ++round)
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      const double v = p[round * kLanes + lane];
      least[lane] = v < least[lane] ? v : least[lane];
      greatest[lane] = v > greatest[lane] ? v : greatest[lane];
    }
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    low[lane] = least[lane];
    high[lane] = greatest[lane];
  }
}

/// Floor for |u| < 2^51: rounded by the sum with 1.5 2^52, then corrected.
[[gnu::always_inline]] inline double floor_of(double u) {
  const double near = (u + 0x1.8p52) - 0x1.8p52;
  return near > u ? near - 1 : near;
}

/// One coordinate of all points; p has x, y, z in turn. Where a point lies in its bin comes from the bin's number on
/// the whole lattice, not from the local one: it must not depend on the base.
[[gnu::always_inline]] inline void place_axis(const double* p, double origin, double edge, double from,
                                              std::size_t count, std::int32_t* bin, double* inside) {
  for (std::size_t n = 0; n < count; ++n) {
    const double u = (p[3 * n] - origin) / edge;
    const double whole = floor_of(u);
    bin[n] = static_cast<std::int32_t>(whole - from);
    inside[n] = u - whole - 0.5;
  }
}

[[gnu::always_inline]] inline std::uint32_t step_of(double within) {
  return static_cast<std::uint32_t>(static_cast<std::int32_t>(floor_of(within * 1024 + 0.5)));
}

/// starts[n]: point n does not lie in the bin of point n - 1.
[[gnu::always_inline]] inline void mark_starts(std::size_t count, Placed& placed) {
  const std::int32_t *i = &placed.bin[0][0], *j = &placed.bin[1][0], *k = &placed.bin[2][0];
  std::uint8_t* starts = &placed.starts[0];
  starts[0] = 1;
  for (std::size_t n = 1; n < count; ++n) starts[n] = ((i[n] ^ i[n - 1]) | (j[n] ^ j[n - 1]) | (k[n] ^ k[n - 1])) != 0;
}

[[gnu::always_inline]] inline void place_points(const double* p, const double* origin, const double* from, double edge,
                                                std::size_t count, Placed& placed) {
  for (int k = 0; k < 3; ++k)
    place_axis(p + k, origin[k], edge, from[k], count, &placed.bin[k][0], &placed.inside[k][0]);
  const double *x = &placed.inside[0][0], *y = &placed.inside[1][0], *z = &placed.inside[2][0];
  double* score = &placed.score[0];
  std::uint32_t* steps = &placed.steps[0];
  for (std::size_t n = 0; n < count; ++n) {
    score[n] = x[n] * x[n] + y[n] * y[n] + z[n] * z[n];
    steps[2 * n] = (step_of(x[n]) & 0xffffu) | (step_of(y[n]) << 16);
    steps[2 * n + 1] = (step_of(z[n]) & 0xffffu) | 0x10000u;
  }
  mark_starts(count, placed);
}

SCANMILL_WIDE void place_wide(const double* p, const double* origin, const double* from, double edge, std::size_t count,
                              Placed& placed) {
  place_points(p, origin, from, edge, count, placed);
}

void place_narrow(const double* p, const double* origin, const double* from, double edge, std::size_t count,
                  Placed& placed) {
  place_points(p, origin, from, edge, count, placed);
}

/// 64 marks at a time: only the starts cost something.
void cut_into_runs(std::size_t count, Placed& placed) {
  constexpr std::size_t kMarks = 64;
  std::size_t runs = 0;
  if (count % kMarks != 0) std::memset(&placed.starts[count], 0, kMarks - count % kMarks);
  for (std::size_t n = 0; n < count; n += kMarks) {
    std::uint64_t marks = 0;
    for (std::size_t part = 0; part < kMarks; part += 16) {
      const __m128i bytes = _mm_load_si128(reinterpret_cast<const __m128i*>(&placed.starts[n + part]));
      const int bits = _mm_movemask_epi8(_mm_cmpgt_epi8(bytes, _mm_setzero_si128()));
      marks |= static_cast<std::uint64_t>(bits) << part;
    }
    for (; marks != 0; marks &= marks - 1) {
      const std::size_t at = n + static_cast<std::size_t>(std::countr_zero(marks));
      placed.first[runs] = static_cast<std::uint32_t>(at);
      placed.bins[runs++] = {placed.bin[0][at], placed.bin[1][at], placed.bin[2][at]};
    }
  }
  placed.first[runs] = static_cast<std::uint32_t>(count);
  placed.runs = runs;
}

template <class Body>
void place_with(Body body, const Lattice& lattice, const BinKey& base, std::span<const Vec3> points, Placed& placed) {
  const double origin[3] = {lattice.origin.x, lattice.origin.y, lattice.origin.z};
  const double from[3] = {static_cast<double>(base.i), static_cast<double>(base.j), static_cast<double>(base.k)};
  if (!points.empty()) body(&points[0].x, origin, from, lattice.edge_mm, points.size(), placed);
  cut_into_runs(points.size(), placed);
}

/// Sums over a tile: every point writes what stands behind it, the last of a run writes last.
/// The least score likewise. Scores are not negative, so that they compare like their bits.
struct LeastScores {
  double* at;  // of the run at hand; at first the place before the first
  std::uint64_t least = 0;
  [[gnu::always_inline]] void take(std::uint64_t starts, const double* score) {
    std::uint64_t bits;
    std::memcpy(&bits, score, sizeof bits);
    at += starts;
    const std::uint64_t so_far = least | (0 - starts);  // of nothing: the greatest
    least = bits < so_far ? bits : so_far;
    std::memcpy(at, &least, sizeof least);
  }
};

#ifdef SCANMILL_WITH_512
/// The three products of a point at once: x y z 1 as pairs with a second 0, times x y z 1, y z x 1 and 1 1 1 1.
SCANMILL_WITH_512 void sum_runs_512(const Placed& placed, RunSums& sums) {
  const std::size_t count = placed.first[placed.runs];
  // Bytes of the steps, from 0 on; those from 128 on become 0.
  alignas(64) static constexpr std::uint8_t kLeft[64] = {
      0,   1,   255, 255, 2,   3,   255, 255, 4,   5,   255, 255, 6,   7,   255, 255, 0,   1,   255, 255, 2,   3,
      255, 255, 4,   5,   255, 255, 6,   7,   255, 255, 0,   1,   255, 255, 2,   3,   255, 255, 4,   5,   255, 255,
      6,   7,   255, 255, 255, 255, 255, 255, 255, 255, 255, 255, 255, 255, 255, 255, 255, 255, 255, 255};
  alignas(64) static constexpr std::uint8_t kRight[64] = {
      0,   1,   255, 255, 2,   3,   255, 255, 4,   5,   255, 255, 6,   7,   255, 255, 2,   3,   255, 255, 4,   5,
      255, 255, 0,   1,   255, 255, 6,   7,   255, 255, 6,   7,   255, 255, 6,   7,   255, 255, 6,   7,   255, 255,
      6,   7,   255, 255, 255, 255, 255, 255, 255, 255, 255, 255, 255, 255, 255, 255, 255, 255, 255, 255};
  const __m512i left = _mm512_load_si512(kLeft), right = _mm512_load_si512(kRight);
  __m512i sum = _mm512_setzero_si512();
  LeastScores scores{sums.least_before.data()};
  RunSums::Sums* behind = &sums.before[0];
  _mm512_store_si512(behind, sum);
  for (std::size_t n = 0; n < count; ++n) {
    long long steps;
    std::memcpy(&steps, &placed.steps[2 * n], sizeof steps);
    const __m512i all = _mm512_set1_epi64(steps);
    sum = _mm512_add_epi32(sum, _mm512_madd_epi16(_mm512_shuffle_epi8(all, left), _mm512_shuffle_epi8(all, right)));
    behind += placed.starts[n];
    _mm512_store_si512(behind, sum);
    scores.take(placed.starts[n], &placed.score[n]);
  }
}
#endif

}  // namespace

Bounds box_of(std::span<const Vec3> points) {
  Bounds box;
  if (points.empty()) return box;
  double low[kLanes], high[kLanes];
  const std::size_t rounds = points.size() / kAtOnce;
  extremes(&points[0].x, rounds, low, high);
  if (rounds > 0)
    for (std::size_t lane = 0; lane < kLanes; lane += 3) {
      box.add(Vec3{low[lane], low[lane + 1], low[lane + 2]});
      box.add(Vec3{high[lane], high[lane + 1], high[lane + 2]});
    }
  for (std::size_t n = rounds * kAtOnce; n < points.size(); ++n) box.add(points[n]);
  return box;
}

void place(const Lattice& lattice, const BinKey& base, std::span<const Vec3> points, Placed& placed) {
  place_with(place_wide, lattice, base, points, placed);
}

void place_plain(const Lattice& lattice, const BinKey& base, std::span<const Vec3> points, Placed& placed) {
  place_with(place_narrow, lattice, base, points, placed);
}

void sum_runs(const Placed& placed, RunSums& sums) {
#ifdef SCANMILL_WITH_512
  static const bool kHas512 = SCANMILL_HAS_512;
  if (kHas512) return sum_runs_512(placed, sums);
#endif
  sum_runs_plain(placed, sums);
}

/// A point's products come from pairs of int16 of which the second is 0.
void sum_runs_plain(const Placed& placed, RunSums& sums) {
  const std::size_t count = placed.first[placed.runs];
  const __m128i none = _mm_setzero_si128();
  __m128i squares = none, mixed = none, plain = none;
  LeastScores scores{sums.least_before.data()};
  std::int32_t* behind = sums.before[0].data();
  auto put = [&](int at, __m128i v) { _mm_store_si128(reinterpret_cast<__m128i*>(behind + at), v); };
  put(0, none), put(4, none), put(8, none);
  for (std::size_t n = 0; n < count; ++n) {
    behind += placed.starts[n] * sums.before[0].size();
    const __m128i steps = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(&placed.steps[2 * n]));
    const __m128i pairs = _mm_unpacklo_epi16(steps, none);
    squares = _mm_add_epi32(squares, _mm_madd_epi16(pairs, pairs));
    mixed = _mm_add_epi32(mixed, _mm_madd_epi16(pairs, _mm_shuffle_epi32(pairs, _MM_SHUFFLE(3, 0, 2, 1))));
    plain = _mm_add_epi32(plain, _mm_srai_epi32(_mm_unpacklo_epi16(none, steps), 16));
    put(0, squares), put(4, mixed), put(8, plain);
    scores.take(placed.starts[n], &placed.score[n]);
  }
}

void WholeSums::add(const WholeSums& other) {
  xx += other.xx;
  yy += other.yy;
  zz += other.zz;
  count += other.count;
  xy += other.xy;
  yz += other.yz;
  xz += other.xz;
  z += other.z;
  x += other.x;
  y += other.y;
}

}  // namespace scanmill::reduce
