// SPDX-License-Identifier: Apache-2.0
#include "reduce/placing.hpp"

#include <emmintrin.h>

namespace scanmill::reduce {
namespace {

static_assert(sizeof(Vec3) == 3 * sizeof(double) && sizeof(LocalBin) == 3 * sizeof(std::int32_t));

/// Two points are three pairs of coordinates: xy zx yz.
struct Pairs {
  __m128d pair[3];
  explicit Pairs(Vec3 v) : pair{_mm_set_pd(v.y, v.x), _mm_set_pd(v.x, v.z), _mm_set_pd(v.z, v.y)} {}
};

struct Placing {
  Pairs origin, base;
  __m128d edge, half = _mm_set1_pd(0.5), one = _mm_set1_pd(1), fine = _mm_set1_pd(1024);

  Placing(const Lattice& lattice, const BinKey& from)
      : origin(lattice.origin),
        base({static_cast<double>(from.i), static_cast<double>(from.j), static_cast<double>(from.k)}),
        edge(_mm_set1_pd(lattice.edge_mm)) {}

  /// Floor of both lanes as doubles; |x| < 2^31. `whole` gets them as integers in its lower half.
  __m128d floor(__m128d x, __m128i& whole) const {
    const __m128i cut = _mm_cvttpd_epi32(x);
    const __m128d value = _mm_cvtepi32_pd(cut);
    const __m128d above = _mm_cmpgt_pd(value, x);  // cut towards zero: one too high for negative fractions
    whole = _mm_add_epi32(cut, _mm_shuffle_epi32(_mm_castpd_si128(above), 0x88));
    return _mm_sub_pd(value, _mm_and_pd(above, one));
  }

  void pair(const double* at, int k, std::int32_t* bins, double* inside, double* steps) const {
    const __m128d u = _mm_div_pd(_mm_sub_pd(_mm_loadu_pd(at), origin.pair[k]), edge);
    const __m128d local = _mm_sub_pd(u, base.pair[k]);  // exact: fewer bits than u
    __m128i bin, unused;
    const __m128d within = _mm_sub_pd(_mm_sub_pd(local, floor(local, bin)), half);
    _mm_storel_epi64(reinterpret_cast<__m128i*>(bins), bin);
    _mm_storeu_pd(inside, within);
    _mm_storeu_pd(steps, floor(_mm_add_pd(_mm_mul_pd(within, fine), half), unused));
  }
};

}  // namespace

Bounds box_of(std::span<const Vec3> points) {
  Bounds box;
  if (points.empty()) return box;
  Pairs low(points[0]), high(points[0]);
  const std::size_t even = points.size() & ~std::size_t{1};
  for (std::size_t i = 0; i < even; i += 2)
    for (int k = 0; k < 3; ++k) {
      const __m128d v = _mm_loadu_pd(&points[i].x + 2 * k);
      low.pair[k] = _mm_min_pd(low.pair[k], v);
      high.pair[k] = _mm_max_pd(high.pair[k], v);
    }
  for (const Pairs* side : {&low, &high}) {
    alignas(16) double lane[6];
    for (int k = 0; k < 3; ++k) _mm_store_pd(lane + 2 * k, side->pair[k]);
    box.add(Vec3{lane[0], lane[1], lane[2]});
    box.add(Vec3{lane[3], lane[4], lane[5]});
  }
  box.add(points.back());
  return box;
}

void place(const Lattice& lattice, const BinKey& base, std::span<const Vec3> points, LocalBin* bins, Vec3* inside, Vec3* steps) {
  const Placing placing(lattice, base);
  const std::size_t even = points.size() & ~std::size_t{1};
  for (std::size_t i = 0; i < even; i += 2)
    for (int k = 0; k < 3; ++k)
      placing.pair(&points[i].x + 2 * k, k, bins[i].data() + 2 * k, &inside[i].x + 2 * k, &steps[i].x + 2 * k);
  if (even == points.size()) return;
  const Vec3 last[2] = {points[even], points[even]};
  LocalBin bin[2];
  Vec3 within[2], fine[2];
  for (int k = 0; k < 3; ++k) placing.pair(&last[0].x + 2 * k, k, bin[0].data() + 2 * k, &within[0].x + 2 * k, &fine[0].x + 2 * k);
  bins[even] = bin[0];
  inside[even] = within[0];
  steps[even] = fine[0];
}

}  // namespace scanmill::reduce
