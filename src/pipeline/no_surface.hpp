// SPDX-License-Identifier: Apache-2.0
// Why points made no triangle, as far as the points tell.
#pragma once
#include <string>

#include "reduce/reduce.hpp"

namespace scanmill::pipeline {

/// A sentence with the number of points and bins, the likely cause and what to do. `kept`: points left by thinning.
std::string no_surface_text(const reduce::ReducedCloud& cloud, const reduce::LatticeParams& lattice,
                            std::uint64_t kept);

}  // namespace scanmill::pipeline
