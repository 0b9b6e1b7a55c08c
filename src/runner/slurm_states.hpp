// SPDX-License-Identifier: Apache-2.0
// What Slurm's words for the state of a job mean to a run. Slurm is asked for liveness and for the reason of a failure
// only; that something is done, its own record tells.
#pragma once
#include <span>
#include <string_view>

namespace scanmill::runner {

enum class JobPhase {
  Waiting,      // alive, not begun
  Running,      // alive
  Ended,        // by itself, with success or not
  OutOfMemory,  // ended by the system: more memory
  TimeLimit,    // ended by the system: more time
  Lost,         // node, preemption, launch: does not count against the scan
  Cancelled,    // by a person
};

struct JobWord {
  std::string_view word;        // as squeue -O State prints it
  std::string_view short_word;  // the compact form (-O StateCompact, %t)
  JobPhase phase;
};

/// All words of Slurm 22.05 to 24.11.
std::span<const JobWord> job_words();
/// The word's entry; nullptr for a word that is not known: alive, with a warning. "CANCELLED by 1000" is CANCELLED.
const JobWord* job_word(std::string_view word);

}  // namespace scanmill::runner
