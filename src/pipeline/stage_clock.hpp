// SPDX-License-Identifier: Apache-2.0
// Wall seconds of each stage of a scan, for run.json only.
#pragma once
#include <chrono>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "base/progress.hpp"

namespace scanmill::pipeline {

class StageClock {
 public:
  explicit StageClock(std::vector<std::pair<std::string, double>>& out) : out_(out), last_(Clock::now()) {}
  /// What passed since the last lap was this stage's.
  void lap(const char* stage) {
    const auto now = Clock::now();
    out_.push_back({stage, std::chrono::duration<double>(now - last_).count()});
    last_ = now;
  }

 private:
  using Clock = std::chrono::steady_clock;
  std::vector<std::pair<std::string, double>>& out_;
  Clock::time_point last_;
};

/// Times the stages that a function tells of under the names it tells them by.
class TimedStages final : public Progress {
 public:
  TimedStages(StageClock& clock, Progress& onward) : clock_(clock), onward_(onward) {}
  void stage(std::string_view name, std::uint64_t done, std::uint64_t total) override {
    {
      const std::lock_guard guard(mutex_);
      if (name != name_) {
        if (!name_.empty()) clock_.lap(name_.c_str());
        name_ = name;
      }
    }
    onward_.stage(name, done, total);
  }
  void end() { clock_.lap(name_.c_str()); }

 private:
  StageClock& clock_;
  Progress& onward_;
  std::mutex mutex_;
  std::string name_;
};

}  // namespace scanmill::pipeline
