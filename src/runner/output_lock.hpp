// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

#include "base/result.hpp"

namespace scanmill::runner {

/// One run at a time on an output tree: a kernel lock that ends with the process, so nothing is left to clear by hand.
class OutputLock {
 public:
  /// Creates `path` when needed, locks it and writes pid and host into it.
  /// errors  IoFailed naming the path; `held_by` is filled and Cancelled returned when another run holds it
  static Result<OutputLock> take(const std::string& path, std::string& held_by);
  OutputLock(OutputLock&& other) noexcept : file_(other.file_) { other.file_ = -1; }
  OutputLock& operator=(OutputLock&&) = delete;
  ~OutputLock();
  /// For a child process: it must not keep the lock alive.
  void forget();

 private:
  explicit OutputLock(int file) : file_(file) {}
  int file_;
};

}  // namespace scanmill::runner
