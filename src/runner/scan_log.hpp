// SPDX-License-Identifier: Apache-2.0
// OUT/logs/<scan>.log: what happened to one scan in its latest run, line by line while it happens.
#pragma once
#include <chrono>
#include <cstdio>
#include <memory>
#include <mutex>
#include <string>

#include "base/progress.hpp"
#include "base/result.hpp"

namespace scanmill::runner {

/// Passes progress on and notes where each stage begins.
class ScanLog final : public Progress {
 public:
  /// errors  IoFailed, NoSpace naming the file
  static Result<std::unique_ptr<ScanLog>> begin(const std::string& path, Progress& onward);
  ~ScanLog() override;
  ScanLog(const ScanLog&) = delete;

  void line(const std::string& text);
  void stage(std::string_view name, std::uint64_t done, std::uint64_t total) override;

 private:
  ScanLog(std::FILE* file, Progress& onward) : file_(file), onward_(onward), began_(std::chrono::steady_clock::now()) {}
  std::FILE* file_;
  Progress& onward_;
  std::chrono::steady_clock::time_point began_;
  std::mutex mutex_;
  std::string stage_;
};

}  // namespace scanmill::runner
