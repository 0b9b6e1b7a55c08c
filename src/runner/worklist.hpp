// SPDX-License-Identifier: Apache-2.0
// What is left of a run, and what of it may start now: heaviest first, as far as cores and memory go round.
#pragma once
#include <chrono>
#include <cstdint>
#include <optional>
#include <set>
#include <vector>

#include "runner/executor.hpp"

namespace scanmill::runner {

using Moment = std::chrono::steady_clock::time_point;

struct WorkItem {
  std::size_t scan = 0;             // place in the selection
  std::uint64_t bytes = 0;          // of its inputs
  std::uint64_t memory = 0;         // known to be needed; 0: go by the bytes
  Moment not_before{};              // waits for its files to settle, or for a fault to pass
  int transient = 0, internal = 0;  // retries so far
  std::string part = {};            // of a scan that is cut; empty: the scan itself
  int waits = 0;                    // for its files to settle, so far
  InputLook seen = {};              // of files from the future, whose dates tell nothing ...
  Moment seen_since{};              // ... since when they look so
};

/// What a machine has, and what of it is free.
struct Room {
  int cores = 1, cores_free = 1;
  std::uint64_t memory = 0, memory_free = 0;  // memory 0: no cap
};

/// Memory that a scan of so many bytes of input is given at least.
std::uint64_t memory_guess(std::uint64_t bytes);

class Worklist {
 public:
  void add(const WorkItem& item);
  bool empty() const { return items_.empty(); }
  std::size_t size() const { return items_.size(); }
  /// Scans other than these; the parts of one count once.
  std::size_t scans_beside(const std::set<std::size_t>& scans) const;
  /// The heaviest item that may start and fits, with its share of cores and memory; it leaves the list. An item that
  /// does not fit is passed over by lighter ones a few times only, so that it gets its turn.
  std::optional<std::pair<WorkItem, Order>> next(const Room& room, Moment now);
  /// When the first of the items that wait may start; nothing when none waits for a time.
  std::optional<Moment> next_moment(Moment now) const;
  /// Items that wait for a time, and when the last of them may start.
  struct Waits {
    std::size_t count = 0;
    Moment last{};
  };
  Waits waits(Moment now) const;
  /// Takes out what is left of one scan.
  void drop(std::size_t scan);
  /// Takes everything out.
  std::vector<WorkItem> drop_all();

 private:
  struct Entry {
    WorkItem item;
    int passed_over = 0;
  };
  std::vector<Entry> items_;  // heaviest first, then by scan
  std::uint64_t bytes_ = 0;   // of all items
};

}  // namespace scanmill::runner
