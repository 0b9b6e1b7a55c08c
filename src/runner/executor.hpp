// SPDX-License-Identifier: Apache-2.0
// Who runs scans: this process, or one process per scan. Executors start, wait, and stop; what is run when, and what
// becomes of failures, is the driver's.
#pragma once
#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "runner/scan_maker.hpp"

namespace scanmill::runner {

/// One attempt to be made.
struct Order {
  std::size_t scan = 0;  // place in the selection
  int threads = 1;
  std::uint64_t memory = 0;  // cap; 0: none
  std::string part = {};     // of a scan that is cut; empty: the scan itself
  std::uint64_t bytes = 0;   // of a part's input
};

/// An attempt that is running, as the operator sees it.
struct Running {
  Order order;
  int pid = 0;  // 0: this process
  std::chrono::steady_clock::time_point began;
  std::string stage;
  std::uint64_t done = 0, total = 0;
  std::chrono::steady_clock::time_point heard = {};  // its latest sign; nothing where the executor does not say
  bool is_queued = false;                            // handed over, and not begun
  std::string place = {};                            // job and node on a cluster; empty: this machine
};

/// An attempt that came to an end.
struct Ended {
  Order order;
  std::optional<Attempt> attempt;  // nothing when the process died without an answer
  std::string stage;               // the latest that it told
  std::string death;               // how it died, e.g. "signal 11 (Segmentation fault)"
  bool killed_by_system = false;   // SIGKILL that this program did not send, where memory may have been short
  bool over_time = false;
  bool reused = false;                  // the process had made other scans before
  double seconds = 0, cpu_seconds = 0;  // of this attempt alone
  std::uint64_t peak_memory = 0;
};

/// Makes one scan; called in the process of the attempt.
using MakeScan = std::function<Attempt(const Order&, Progress&)>;

class Executor {
 public:
  virtual ~Executor() = default;
  /// errors  Transient faults of the system: no process, no pipe
  virtual Result<void> start(const Order& order) = 0;
  /// Those that ended; waits up to `timeout` for the first when there is none, and returns early on a signal.
  virtual std::vector<Ended> wait(std::chrono::milliseconds timeout) = 0;
  virtual const std::vector<Running>& running() const = 0;
  /// Asks all to stop at the next chunk.
  virtual void stop_all() = 0;
  /// Ends all at once.
  virtual void kill_all() = 0;
  /// Starts nothing that waits inside the executor; what is at work comes to its end.
  virtual void drain() {}
  /// Works on other machines: cores and memory here do not limit it, and attempt folders may be another copy's.
  virtual bool is_remote() const { return false; }
  /// What those that are queued wait for; may be empty.
  virtual std::string waits_for() const { return {}; }
  /// Why nothing can be started any more.
  virtual std::optional<Error> broken() const { return std::nullopt; }
};

/// In this process, one after the other: start() returns when the scan is made. Progress goes to `progress`.
std::unique_ptr<Executor> make_inline_executor(MakeScan make, Progress& progress);

struct LocalOptions {
  double time_limit_s = 6 * 3600;
  std::function<void()> in_child;  // closes what only the driver may hold
};
/// A process for each attempt, which dies with this one; small scans follow one another in a process as long as all
/// goes well. This process must have one thread only when start() is called.
std::unique_ptr<Executor> make_local_executor(MakeScan make, LocalOptions options);

}  // namespace scanmill::runner
