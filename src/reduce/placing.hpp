// SPDX-License-Identifier: Apache-2.0
// The innermost loops of binning, two doubles at a time in the SSE2 that every x86-64 has. Internal to `reduce`.
#pragma once
#include <cstddef>
#include <span>

#include "lattice/bin_index.hpp"

namespace scanmill::reduce {

/// Smallest box around the points.
Bounds box_of(std::span<const Vec3> points);

/// Where points lie: `bins` local to `base`; `inside` in bin edges about the bin's centre, [-1/2, 1/2); `steps` the same in
/// whole 1/1024 of a bin edge, floor(inside 1024 + 1/2). Every value is the one the plain formulas give, to the last bit.
/// All points must be less than 2^30 bins from the base.
void place(const Lattice& lattice, const BinKey& base, std::span<const Vec3> points, LocalBin* bins, Vec3* inside, Vec3* steps);

/// Sums of whole numbers below 2^53 in doubles: exact, so they commute like integers and cost half.
/// count, sums x y z, products xx xy xz yy yz zz.
struct alignas(16) WholeSums {
  double value[10] = {};
  void add(Vec3 s) {
    const double terms[10] = {1, s.x, s.y, s.z, s.x * s.x, s.x * s.y, s.x * s.z, s.y * s.y, s.y * s.z, s.z * s.z};
    for (int k = 0; k < 10; ++k) value[k] += terms[k];
  }
  void add(const WholeSums& other) {
    for (int k = 0; k < 10; ++k) value[k] += other.value[k];
  }
};

}  // namespace scanmill::reduce
