// SPDX-License-Identifier: Apache-2.0
#include "runner/slurm_states.hpp"

#include <algorithm>

namespace scanmill::runner {
namespace {

// squeue(1), "JOB STATE CODES"; and what later versions added.
constexpr JobWord kWords[] = {
    {"PENDING", "PD", JobPhase::Waiting},       {"CONFIGURING", "CF", JobPhase::Waiting},
    {"POWER_UP_NODE", "PU", JobPhase::Waiting}, {"REQUEUED", "RQ", JobPhase::Waiting},
    {"REQUEUE_FED", "RF", JobPhase::Waiting},   {"REQUEUE_HOLD", "RH", JobPhase::Waiting},
    {"RESV_DEL_HOLD", "RD", JobPhase::Waiting}, {"SPECIAL_EXIT", "SE", JobPhase::Waiting},
    {"EXPEDITING", "EX", JobPhase::Waiting},    {"RUNNING", "R", JobPhase::Running},
    {"COMPLETING", "CG", JobPhase::Running},    {"RESIZING", "RS", JobPhase::Running},
    {"SIGNALING", "SI", JobPhase::Running},     {"STAGE_OUT", "SO", JobPhase::Running},
    {"STOPPED", "ST", JobPhase::Running},       {"SUSPENDED", "S", JobPhase::Running},
    {"UPDATE_DB", "UD", JobPhase::Running},     {"COMPLETED", "CD", JobPhase::Ended},
    {"FAILED", "F", JobPhase::Ended},           {"OUT_OF_MEMORY", "OOM", JobPhase::OutOfMemory},
    {"TIMEOUT", "TO", JobPhase::TimeLimit},     {"DEADLINE", "DL", JobPhase::Lost},
    {"BOOT_FAIL", "BF", JobPhase::Lost},        {"LAUNCH_FAILED", "LF", JobPhase::Lost},
    {"RECONFIG_FAIL", "RC", JobPhase::Lost},    {"NODE_FAIL", "NF", JobPhase::Lost},
    {"PREEMPTED", "PR", JobPhase::Lost},        {"REVOKED", "RV", JobPhase::Lost},
    {"CANCELLED", "CA", JobPhase::Cancelled},
};

}  // namespace

std::span<const JobWord> job_words() { return kWords; }

const JobWord* job_word(std::string_view word) {
  word = word.substr(0, word.find_first_of(" +"));
  const auto found = std::find_if(std::begin(kWords), std::end(kWords),
                                  [&](const JobWord& one) { return one.word == word || one.short_word == word; });
  return found == std::end(kWords) ? nullptr : found;
}

}  // namespace scanmill::runner
