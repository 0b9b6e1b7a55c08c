// SPDX-License-Identifier: Apache-2.0
// A command of the cluster, run to its end or to a time-out: with the controller down squeue hangs.
#pragma once
#include <chrono>
#include <functional>
#include <string>
#include <vector>

namespace scanmill::runner {

struct CommandReply {
  bool started = false, timed_out = false;
  int status = -1;  // exit code; 128 + signal when it was killed
  int signal = 0;   // that killed it, or a command of its own that it waited for; 0: it ended by itself
  std::string out, err;

  bool ok() const { return started && !timed_out && status == 0; }
  /// What went wrong, on one line.
  std::string problem() const;
};

/// Runs words[0] from PATH, without Slurm's own variables of the job that this process may be part of (SLURM_CONF
/// stays): sbatch and squeue would take them for options. `give_up`: asked ten times a second; true ends the wait.
CommandReply run_command(const std::vector<std::string>& words, std::chrono::milliseconds limit,
                         const std::function<bool()>& give_up = {});

}  // namespace scanmill::runner
