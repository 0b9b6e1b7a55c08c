// SPDX-License-Identifier: Apache-2.0
// Another process, and what it and all it starts take from the machine while it runs.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "base/context.hpp"
#include "base/result.hpp"

namespace scanmill::pipeline {

/// A look at the tree of processes.
struct TreeSample {
  double wall_s = 0;  // since the start of the child
  double cpu_s = 0;   // user and system, all processes so far
  // Memory that must stay or go to swap: private pages and shared memory, not pages of files, which the system takes
  // back when it needs room. Summed over the processes alive.
  std::uint64_t held_bytes = 0;
  std::uint64_t resident_bytes = 0;  // pages of files included; those that processes share count for each
  std::uint64_t said_bytes = 0;      // of output so far
};

struct ChildRun {
  int exit_code = 0;  // 128 + signal when one ended it
  double cpu_s = 0, wall_s = 0;
  std::string said;                 // the end of both its outputs, 1 MiB at most
  std::uint64_t said_from = 0;      // bytes of output before it
  std::vector<TreeSample> samples;  // in the order of time, at least one
  std::uint64_t peak_held = 0, peak_resident = 0;
};

/// Runs `words[0]` with the other words and looks at its tree of processes every `interval_ms`. When the context is
/// cancelled, the child is asked to stop (SIGTERM) and waited for.
/// errors  IoFailed when it cannot be started; Cancelled
Result<ChildRun> run_watched(const std::vector<std::string>& words, int interval_ms, const Context& context);

}  // namespace scanmill::pipeline
