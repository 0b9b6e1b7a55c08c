// SPDX-License-Identifier: Apache-2.0
// Which points are no vertices, and why. Internal to `reduce`.
#pragma once
#include <vector>

#include "reduce/reduce.hpp"

namespace scanmill::reduce {

/// By the rules that look at no other point; after the frames are there.
void drop_alone(ReducedCloud& cloud, const Params& params, const Context& context);
/// Those too near to better ones. `seen` and what is returned: as thin().
std::vector<std::uint8_t> drop_near(ReducedCloud& cloud, const std::vector<std::uint8_t>& seen, const Params& params,
                                    const Context& context);
void count_drops(const ReducedCloud& cloud, Report& report);

}  // namespace scanmill::reduce
