// SPDX-License-Identifier: Apache-2.0
// All crossings among the triangles at once. Internal to `stars`.
#pragma once
#include <array>
#include <vector>

#include "stars/site.hpp"

namespace scanmill::stars {

/// Every pair of living triangles that cross (exact), each once, the lesser number first; in no promised order, but the
/// same for any number of threads. Incomplete when cancelled.
///
/// cost  about 0.25 us per triangle where surfaces do not meet
std::vector<std::array<std::uint32_t, 2>> crossing_pairs(const Site& site, const Context& context);

/// All pairs of triangles at v were seen to lie apart: v's fan is closed and a plane shows it as one turn without
/// folds. False decides nothing.
bool unfolded_fan(const Site& site, std::uint32_t v);

}  // namespace scanmill::stars
