// SPDX-License-Identifier: Apache-2.0
// The books of the Slurm executor: what was handed in, and what is known of it.
#pragma once
#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "runner/slurm_states.hpp"
#include "runner/slurm_waves.hpp"
#include "runner/task_result.hpp"
#include "runner/worklist.hpp"

namespace scanmill::runner {

/// An element of a wave's array.
struct Element {
  std::vector<std::size_t> scans;  // units of the executor, by item; kNoScan: nobody waits for it
  std::vector<bool> recorded;      // by item
  std::optional<JobPhase> phase;   // the last that Slurm told; nothing: never seen
  std::string word, reason, job, node;
  int wait_status = 0;
  bool seen = false;       // in the latest answer
  bool settled = false;    // nothing more is expected of it
  bool began = false;      // its script ran on a node
  bool forgotten = false;  // Slurm lost its start, and it was taken back
  int restarts = 0;        // times that Slurm put it back; -1: not told
  Moment over_since{};     // ended, says Slurm
  Moment last_sign{};      // submitted, seen alive, or heard of
  std::string beat_file;   // of its latest sign of life
  std::int64_t beat_ns = 0;
  std::optional<Heartbeat> heartbeat;
  Moment beat_read{}, heard{}, began_at{};

  bool is_over() const { return phase && *phase != JobPhase::Waiting && *phase != JobPhase::Running; }
  bool has_all() const { return std::find(recorded.begin(), recorded.end(), false) == recorded.end(); }
};

inline constexpr std::size_t kNoScan = static_cast<std::size_t>(-1);

/// An array, or what is to become one.
struct Wave {
  WaveFolder folder;
  std::vector<Element> elements;
  int threads = 1;
  std::uint64_t memory = 0;  // of each item
  double seconds = 0;        // time limit of an element
  bool submitted = false, looked_up = true, closed = false;
  /// The controller was out of reach at some time since it was submitted, or forgot of it: what Slurm tells of its
  /// elements may be of others, and an end without a record is nobody's fault.
  bool in_doubt = false;
  int tries = 0;
};

/// A scan, or a part of one, that the driver waits for.
struct Wanted {
  Order order;
  std::size_t unit = 0;    // its number for the executor
  std::string name, keys;  // digest of its keys
  std::uint64_t bytes = 0;
  double granted_s = 0;  // of an element's time limit
  bool waits = true;     // to be submitted
  bool alone = false;    // not with others in an element
  Moment not_before{}, began{};
  int lost = 0, cancelled = 0, launches = 0, doubts = 0;
};

}  // namespace scanmill::runner
