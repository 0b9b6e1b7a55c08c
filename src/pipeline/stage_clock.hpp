// SPDX-License-Identifier: Apache-2.0
// Wall and processor seconds of each stage of a scan, for run.json only.
#pragma once
#include <sys/resource.h>

#include <chrono>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "base/progress.hpp"

namespace scanmill::pipeline {

/// By name, in the order of the stages.
struct StageTimes {
  std::vector<std::pair<std::string, double>> wall_s, cpu_s;  // cpu: of the whole process
};

class StageClock {
 public:
  explicit StageClock(StageTimes& out) : out_(out) {}
  /// What passed since the last lap was this stage's, and adds to what it took before.
  void lap(const char* stage) {
    const auto now = Clock::now();
    const double cpu = cpu_now();
    add(out_.wall_s, stage, std::chrono::duration<double>(now - last_).count());
    add(out_.cpu_s, stage, cpu - last_cpu_);
    last_ = now;
    last_cpu_ = cpu;
  }

 private:
  using Clock = std::chrono::steady_clock;
  static void add(std::vector<std::pair<std::string, double>>& sums, const char* stage, double seconds) {
    for (auto& [name, sum] : sums)
      if (name == stage) {
        sum += seconds;
        return;
      }
    sums.push_back({stage, seconds});
  }
  static double cpu_now() {
    rusage use{};
    getrusage(RUSAGE_SELF, &use);
    const auto seconds = [](const timeval& t) {
      return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
    };
    return seconds(use.ru_utime) + seconds(use.ru_stime);
  }
  StageTimes& out_;
  Clock::time_point last_ = Clock::now();
  double last_cpu_ = cpu_now();
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
