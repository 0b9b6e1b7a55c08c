// SPDX-License-Identifier: Apache-2.0
// OUT/quarantine.json: scans that failed for a reason that will be there tomorrow. The same work is not tried again
// until a file, a key or a stage changes, or someone says `retry`.
#pragma once
#include <map>
#include <string>

#include "base/result.hpp"
#include "runner/run_report.hpp"

namespace scanmill::runner {

class Quarantine {
 public:
  struct Entry {
    std::string fingerprint;
    std::string error;  // as it was shown
    FailureClass failure = FailureClass::BadInput;
    std::string since;  // UTC
    int attempts = 1;
    std::uint64_t memory = 0;  // of class resource: with less or as much it is not tried again
    double time_limit_s = 0;   // that was reached: with this or less it is not tried again
    std::uint64_t disk = 0;    // the same for a limit on disk
  };
  /// An unreadable file counts as empty: the scans are tried again.
  static Quarantine load(const std::string& path);
  Result<void> save(const std::string& path) const;

  /// What this run gives a scan; 0: no limit.
  struct Limits {
    std::uint64_t memory = 0;
    double time_limit_s = 0;
    std::uint64_t disk = 0;
  };
  /// The entry of exactly this work where it is given no more of what it lacked than it had, or nullptr.
  const Entry* find(const std::string& scan, const std::string& fingerprint, const Limits& limits) const;
  void add(const std::string& scan, Entry entry);
  /// True when it was there.
  bool remove(const std::string& scan);
  std::vector<std::string> names() const;

 private:
  std::map<std::string, Entry> entries_;
  bool changed_ = false;
};

}  // namespace scanmill::runner
