// SPDX-License-Identifier: Apache-2.0
// In which order the points of a large cloud are best read.
#pragma once
#include <memory>

#include "base/context.hpp"
#include "base/progress.hpp"
#include "cloud/cloud.hpp"
#include "reduce/reduce.hpp"

namespace scanmill::pipeline {

/// The same points, block by block through space; brought together first where blocks span the cloud. Nothing where the
/// order makes no difference. A scan that would fill the disk with what
/// does not fit into memory is refused here, before any of its work is done. `points` must outlive the result.
/// errors  NoSpace of "memory" with the figures; those of the points
/// cost    a pass over the points, and one to bring them together
Result<std::unique_ptr<PointSource>> in_best_order(const PointSource& points, const reduce::LatticeParams& lattice,
                                                   const reduce::Params& params, const Context& context,
                                                   Progress& progress);
/// The same for a cloud, or a piece of one, that is passed over once or twice: only where memory is short and a look at
/// a few blocks says that it is worth it.
Result<std::unique_ptr<PointSource>> gathered_if_scattered(const PointSource& points,
                                                           const reduce::LatticeParams& lattice,
                                                           const reduce::Params& params, const Context& context,
                                                           Progress& progress);

}  // namespace scanmill::pipeline
