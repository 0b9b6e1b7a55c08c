// SPDX-License-Identifier: Apache-2.0
// One run of a job: which scans need work, who makes them when, and what becomes of those that fail.
#pragma once
#include <atomic>
#include <cstdint>
#include <string>
#include <vector>

#include "base/context.hpp"
#include "document/document.hpp"
#include "runner/console.hpp"
#include "runner/work.hpp"

namespace scanmill::runner {

/// Exit codes (README, "Exit codes"); 128 + signal when interrupted.
inline constexpr int kExitGood = 0, kExitInternal = 1, kExitUsage = 2, kExitScans = 3, kExitGate = 4, kExitCluster = 6,
                     kExitBusy = 75;

/// The exit code of a command that failed with this error.
int exit_code_of(const Error& error);

/// How work is asked to stop; set by signal handlers. A run that drains lets the scans at work come to their end after
/// the first request and stops them after the second.
struct Stop {
  CancelFlag flag;             // stop at the next chunk
  std::atomic<int> signal{0};  // the first request
  std::atomic<int> requests{0};
  std::atomic<bool> drains{false};
  std::atomic<bool> snapshot{false};  // say what is going on (SIGUSR1)

  /// Safe in a signal handler. True when this request is one too many: end the process.
  bool request(int number) {
    int none = 0;
    signal.compare_exchange_strong(none, number);
    const int before = requests.fetch_add(1);
    if (before >= (drains.load() ? 1 : 0)) flag.set();
    return before >= (drains.load() ? 2 : 1);
  }
};

struct RunOptions {
  std::string job;
  std::string out;  // empty: the job file's name without suffix, with ".out", in the current folder
  std::vector<std::string>
      only;  // globs; empty: what the job selects. A scan named here is tried even when quarantined
  std::vector<std::string> sets;
  bool dry_run = false;  // writes nothing
  bool explain = false;
  std::string dag;           // dot or json: print what a dry run finds as a graph, and nothing else
  std::string executor;      // inline, local or slurm; empty: the job's
  std::int64_t threads = 0;  // 0: the job's
  std::uint64_t memory = 0;  // 0: the job's
  std::uint64_t disk = 0;    // 0: the job's
  std::string version;
  document::Node libraries = document::Node::map();
};

/// Runs the job and returns the exit code; the last line has been shown.
int run_job(const RunOptions& options, Work& work, Console& console, Stop& stop);

struct JobCheck {
  std::vector<std::string> problems;  // a line each
  std::vector<std::string> notes;     // what a run would say and go on
};

/// Checks the job, what each of its scans would be made with, and the scans that the job itself describes.
JobCheck check_job(const std::string& path, std::span<const std::string> sets, Work& work);

}  // namespace scanmill::runner
