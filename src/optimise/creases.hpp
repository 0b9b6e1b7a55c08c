// SPDX-License-Identifier: Apache-2.0
// How sharply the surface bends, in whole numbers, so that the sums do not depend on order. Internal to `optimise`.
#pragma once
#include "base/context.hpp"
#include "optimise/optimise.hpp"
#include "optimise/surface.hpp"

namespace scanmill::optimise {

/// unit_mm: lengths are summed in 2^-24 of it.
Creases creases_of(const Surface& surface, double unit_mm, const Context& context);

}  // namespace scanmill::optimise
