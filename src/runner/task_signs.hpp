// SPDX-License-Identifier: Apache-2.0
// Whether tasks of a worklist that another engine runs are at work, by the signs of life that they leave beside it.
#pragma once
#include "base/result.hpp"
#include "runner/output_tree.hpp"

namespace scanmill::runner {

/// Takes away signs of tasks that are over: all their records are there, or their process was one of this machine and
/// has ended. errors  Cancelled when other tasks may be at work, naming one and the time from which it counts as dead
Result<void> wait_for_no_task(const OutputTree& tree);

}  // namespace scanmill::runner
