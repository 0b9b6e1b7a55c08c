// SPDX-License-Identifier: Apache-2.0
// Content hashes of input files; a file whose stamp did not change since is not read again.
#pragma once
#include <cstdint>
#include <map>
#include <mutex>
#include <span>
#include <string>

#include "base/context.hpp"
#include "base/result.hpp"
#include "document/document.hpp"
#include "store/files.hpp"

namespace scanmill::pipeline {

/// Path -> (stamp, sha256). Safe from several threads. What it holds decides speed only, never a result: a file that
/// was written less than two seconds before it was hashed is hashed again next time, because its stamp could stay the
/// same through another write.
class HashCache {
 public:
  struct Entry {
    store::FileStamp stamp;
    std::string sha256;
    bool trusted = false;  // old enough when it was hashed
  };

  /// Hash and size of the file as it is now.
  /// errors  those of store::open_file; BadInput when the file changed while it was read
  Result<Entry> entry_of(const std::string& path, const std::string& shown);

  /// True when entry_of would not read the file.
  bool knows(const std::string& path) const;

  /// What was saved before; a text that is not readable leaves the cache empty.
  void load(std::string_view text);
  /// Trusted entries, in byte order of their paths.
  std::string save() const;
  /// Those of these files alone.
  std::string save(std::span<const std::string> paths) const;

 private:
  mutable std::mutex mutex_;
  std::map<std::string, Entry> entries_;
};

}  // namespace scanmill::pipeline
