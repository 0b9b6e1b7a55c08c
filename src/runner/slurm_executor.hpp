// SPDX-License-Identifier: Apache-2.0
// Scans as elements of Slurm job arrays. We decide order, packing and retries; Slurm places and limits. That a scan is
// made, its task's own record tells, never Slurm: accepted jobs were seen to vanish with a controller, and finished
// ones to be held as failed. Slurm is asked for liveness and for the reason of a failure.
#pragma once
#include <functional>
#include <memory>
#include <string>

#include "runner/driver.hpp"
#include "runner/executor.hpp"
#include "runner/job_scans.hpp"
#include "runner/task_file.hpp"

namespace scanmill::runner {

struct SlurmOptions {
  ClusterKeys keys;
  const OutputTree& tree;
  const Selection& selection;
  const Stop& stop;
  TaskFile frame;                    // of every worklist: job, out, limits; without keys and tasks
  double bytes_per_core_second = 0;  // of earlier runs; 0: not known
  std::uint64_t most_memory = 0;     // of an element
  std::function<std::uint64_t(std::size_t scan)> bytes_of;
  std::function<const ScanEntry&(std::size_t scan)> entry_of;
  std::function<void(const std::string& scan, const std::string& text)> note;
};

/// Takes over the open waves of a driver that died before it submits anything of its own. Its destructor closes all
/// waves; what Slurm still has of them is cancelled.
std::unique_ptr<Executor> make_slurm_executor(SlurmOptions options);

/// Memory that an element may have, of the cluster's largest node; what the task itself needs is taken off. `is_known`:
/// Slurm told; else it is a guess.
std::uint64_t cluster_memory(const ClusterKeys& keys, bool& is_known);

}  // namespace scanmill::runner
