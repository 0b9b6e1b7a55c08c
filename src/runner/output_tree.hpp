// SPDX-License-Identifier: Apache-2.0
// Where things are in an output tree, and the one switch by which a scan's result appears.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "base/result.hpp"

namespace scanmill::runner {

inline constexpr const char* kPartsFolder = "parts";  // in OUT/work

class OutputTree {
 public:
  explicit OutputTree(std::string root) : root_(std::move(root)) {}

  const std::string& root() const { return root_; }
  std::string scan(const std::string& name) const { return root_ + "/scans/" + name; }
  std::string log(const std::string& name) const { return root_ + "/logs/" + name + ".log"; }
  std::string parts() const { return root_ + "/work/" + kPartsFolder; }
  std::string parts(const std::string& name) const { return parts() + "/" + name; }  // of a scan that is cut
  std::string run_file() const { return root_ + "/run.json"; }
  std::string journal() const { return root_ + "/journal"; }
  std::string live_file() const { return root_ + "/journal/live.json"; }
  std::string cancel_file() const { return root_ + "/journal/cancel"; }
  std::string lock_file() const { return root_ + "/journal/lock"; }
  std::string hashes_file() const { return root_ + "/journal/hashes.json"; }
  std::string quarantine_file() const { return root_ + "/quarantine.json"; }
  std::string names_file() const { return root_ + "/journal/names.json"; }
  std::string night_file() const { return root_ + "/journal/night.json"; }
  std::string page_file() const { return root_ + "/report.html"; }
  std::string junit_file() const { return root_ + "/junit.xml"; }
  std::string trace_file() const { return root_ + "/trace.tsv"; }
  std::string metrics_file() const { return root_ + "/scanmill.prom"; }

  /// Makes the folders scans, logs and journal.
  /// errors  IoFailed, NoSpace naming the folder
  Result<void> prepare() const;
  /// Attempts and temporary files that dead runs left behind.
  std::vector<std::string> leftovers() const;
  /// Removes them; only the holder of the lock may call this.
  Result<void> remove_leftovers() const;
  /// An empty folder ".<last part of the name>.<attempt>" beside the scan's folder.
  Result<std::string> begin_attempt(const std::string& name) const;
  /// The attempt takes the place of the scan's folder in one step.
  Result<void> commit(const std::string& attempt, const std::string& name) const;
  /// Removes what attempts at a scan left whose process died; none may be at work on it.
  void remove_attempts(const std::string& name) const;
  /// Removes the parts of a scan, and the folders that held nothing else.
  void remove_parts(const std::string& name) const;
  /// What they take now.
  std::uint64_t bytes_of_parts(const std::string& name) const;
  /// Names of all scans with a result here, in byte order.
  std::vector<std::string> finished() const;
  /// True when the tree takes no more bytes.
  bool is_unwritable() const;

 private:
  std::string root_;
};

/// The folders that a run makes, and empties of what dead runs left, must not be the archive or hold it. An output
/// folder inside the archive is fine. Links and ".." are followed.
/// errors  BadUsage
Result<void> check_out_of_archive(const OutputTree& tree, const std::string& archive);

}  // namespace scanmill::runner
