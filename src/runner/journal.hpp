// SPDX-License-Identifier: Apache-2.0
// OUT/journal/<epoch>.jsonl: what a run did, line by line; one file per incarnation of the driver, only appended to.
// Each line carries a checksum, so a tail that was cut by a crash is known and left out.
#pragma once
#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "document/document.hpp"

namespace scanmill::runner {

class Journal {
 public:
  /// Opens the file of the next epoch and writes `head` into it, synced.
  /// errors  IoFailed, NoSpace naming the file
  static Result<Journal> begin(const std::string& folder, document::Node head);
  Journal(Journal&& other) noexcept;
  Journal& operator=(Journal&&) = delete;
  ~Journal();

  std::uint64_t epoch() const { return epoch_; }
  /// Adds a line; it is durable after the next commit.
  void add(document::Node event);
  /// Writes and syncs what was added when it is old (200 ms) or much (32 lines) enough, or `now`.
  /// errors  IoFailed, NoSpace naming the file
  Result<void> commit(bool now = false);
  /// For a child process: the descriptor is closed, nothing is written.
  void forget();

 private:
  Journal(int file, std::string path, std::uint64_t epoch) : file_(file), path_(std::move(path)), epoch_(epoch) {}
  int file_;
  std::string path_;
  std::uint64_t epoch_;
  std::string waiting_;
  int lines_ = 0;
  std::chrono::steady_clock::time_point oldest_{};
};

/// A line as it stands in the file, line feed included.
std::string journal_line(const document::Node& event);
/// The whole lines of a journal's text up to the first that is cut or damaged.
std::vector<document::Node> read_journal(const std::string& text);
/// Numbers of the journals in the folder, ascending.
std::vector<std::uint64_t> epochs_in(const std::string& folder);
/// 0 when there is none.
std::uint64_t latest_epoch(const std::string& folder);
std::string journal_file(const std::string& folder, std::uint64_t epoch);
/// The lines of one epoch; none when it cannot be read.
std::vector<document::Node> load_journal(const std::string& folder, std::uint64_t epoch);

}  // namespace scanmill::runner
