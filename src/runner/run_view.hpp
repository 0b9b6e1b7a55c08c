// SPDX-License-Identifier: Apache-2.0
// A run as its operator sees it while it goes on: a block on a terminal, a line a minute in a log, a file for `status`.
#pragma once
#include <chrono>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "runner/console.hpp"
#include "runner/executor.hpp"
#include "runner/run_report.hpp"

namespace scanmill::runner {

/// How far a scan is that is cut.
struct PartCount {
  std::size_t done = 0, all = 0;
  std::uint64_t bytes = 0;  // of the scan
  double core_seconds = 0;  // that its parts have taken
  // Of the CPU time that all of it takes: done, of each part at work now, and done by an earlier run.
  double share = 0, next = 0, found = 0;
};

/// What there is to see.
struct RunPicture {
  const RunReport& report;
  std::span<const Running> running;
  std::span<const std::string> names;  // of the selection, by Order::scan
  std::size_t waiting = 0;             // scans of which nothing is at work
  std::uint64_t bytes_done = 0, bytes_all = 0;
  std::string remark;  // what the run waits for, or that it is ending; may be empty
  double seconds = 0;  // since the run began
  bool is_stopping = false;
  int cores = 0;            // that the run has here; 0: elsewhere, and the two below are not told
  double core_seconds = 0;  // that went into bytes_done
  double bytes_begun = 0;   // of what is at work, by the speed so far
  double bytes_found = 0;   // of bytes_done, made by an earlier run: they tell no speed
  const std::map<std::size_t, PartCount>* parts = nullptr;  // of scans that are cut, by Order::scan
};

/// By the bytes that are through, and the core time that they took; 0 while that says nothing.
double seconds_left(const RunPicture& picture);

/// ", no sign for 20 s", or nothing for what is not long.
std::string silence_text(double seconds);
/// The lines of the block, slowest scan first.
std::vector<std::string> block_of(const RunPicture& picture);
/// "7 of 12 done, 1 failed, 2 running (bun grow 0:41), 3 waiting | 58 % of 1.2 GB | 0:05:10, about 0:03:40 left"
std::string line_of(const RunPicture& picture);
/// journal/live.json, for `scanmill status`.
document::Node to_document(const RunPicture& picture, std::uint64_t epoch);

/// Decides when which of them is shown.
class RunView {
 public:
  RunView(Console& console, std::string live_file, std::uint64_t epoch)
      : console_(console), live_file_(std::move(live_file)), epoch_(epoch) {}
  void show(const RunPicture& picture);
  /// On stderr, whatever the style (SIGUSR1).
  void snapshot(const RunPicture& picture);
  void end();

 private:
  using Clock = std::chrono::steady_clock;
  Console& console_;
  std::string live_file_;
  std::uint64_t epoch_;
  Clock::time_point next_show_{}, next_save_{};
  bool began_ = false;
};

}  // namespace scanmill::runner
