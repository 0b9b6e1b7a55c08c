// SPDX-License-Identifier: Apache-2.0
// The pictures of a replay.
#pragma once
#include <string>
#include <vector>

#include "pipeline/replay_plan.hpp"

namespace scanmill::pipeline {

/// machine.png (the whole machine with the way of the head), part.png (the part, and where the head looks),
/// timeline.png (joints over time; only with joints). Returns the names written.
Result<std::vector<std::string>> write_replay_pictures(const Rehearsal& rehearsal, const std::string& folder,
                                                       const Context& context, Progress& progress);

}  // namespace scanmill::pipeline
