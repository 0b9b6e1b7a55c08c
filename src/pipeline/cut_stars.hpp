// SPDX-License-Identifier: Apache-2.0
// The tasks `stars` of a scan that is cut (cut_scan.hpp).
#pragma once
#include <vector>

#include "base/context.hpp"
#include "pipeline/cut_scan.hpp"
#include "stars/parts.hpp"

namespace scanmill::pipeline {

/// The task `stars batch`; nothing is done when its file is there.
/// errors  IoFailed naming the task that makes what is missing; those of the stage; NoSpace
Result<void> star_batch(const Cut& cut, std::uint32_t batch, const What& what, const Context& context);
/// Of all batches, in the order of their rows.
Result<std::vector<stars::Ballot>> read_ballots(const Cut& cut);

}  // namespace scanmill::pipeline
