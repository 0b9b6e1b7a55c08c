// SPDX-License-Identifier: Apache-2.0
// Scans that failed because of their input. The same work is not tried again until a file, a key or a stage changes.
#pragma once
#include <map>
#include <string>

#include "base/result.hpp"

namespace scanmill::runner {

class Quarantine {
 public:
  struct Entry {
    std::string fingerprint;
    std::string error;  // as it was shown
  };
  /// An unreadable file counts as empty: the scans are tried again.
  static Quarantine load(const std::string& path);
  Result<void> save(const std::string& path) const;

  /// The entry of exactly this work, or nullptr.
  const Entry* find(const std::string& scan, const std::string& fingerprint) const;
  void add(const std::string& scan, Entry entry);
  void remove(const std::string& scan);

 private:
  std::map<std::string, Entry> entries_;
  bool changed_ = false;
};

}  // namespace scanmill::runner
