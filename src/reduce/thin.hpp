// SPDX-License-Identifier: Apache-2.0
// c2: which of two near points stays. Internal to `reduce`.
#pragma once
#include <vector>

#include "reduce/reduce.hpp"

namespace scanmill::reduce {

/// Bins around a point that thinning looks at for one decision.
inline constexpr std::int32_t kThinReach = 3;

/// The greedy independent set of the candidates in the order (distance, key): one within c2 h of a kept one in the
/// 5x5x5 window is dropped. Found by rounds in which a point decides once all better neighbours have: the same set as
/// the serial greedy walk, for any threads. Points of two sides of a thin wall (signs known, normals opposed) do not
/// compete. On projected positions it then closes what it opened: where the points lie in rows that beat with the bins,
/// two neighbours can both be dropped for the sake of points on their far sides, and the strip between these is wider
/// than any triangle may span. A dropped point beside a void between measured points stays; of several, the greedy set
/// again.
///
/// seen      per row: all occupied bins within kThinReach of its own are among the rows; empty: of every row
/// returns   per row 1 where rows that are not there could decide (its `drop` says Kept then); empty with `seen` empty
/// cost      0.4 us per bin
std::vector<std::uint8_t> thin(ReducedCloud& cloud, const std::vector<double>& order, double distance_bins,
                               bool on_projected, const std::vector<std::uint8_t>& seen, const Context& context);

}  // namespace scanmill::reduce
