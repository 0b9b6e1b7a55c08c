// SPDX-License-Identifier: Apache-2.0
// How sharply the surface bends, in whole numbers, so that the sums do not depend on order. Internal to `optimise`.
#pragma once
#include <span>

#include "base/context.hpp"
#include "optimise/optimise.hpp"

namespace scanmill::optimise {

class Surface;

struct CreaseSums {
  std::uint64_t edges = 0, sharp = 0, degrees = 0, length = 0, square = 0;
  void add(const CreaseSums& other);
  Creases creases(double unit_mm) const;
};

/// unit_mm: lengths are summed in 2^-24 of it. own: of which vertices edges count, at the lesser one; empty: of all.
CreaseSums creases_of(const Surface& surface, double unit_mm, const Context& context,
                      std::span<const std::uint8_t> own = {});

}  // namespace scanmill::optimise
