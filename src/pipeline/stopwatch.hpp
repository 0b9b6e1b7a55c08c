// SPDX-License-Identifier: Apache-2.0
// What a call costs the process, for the bench.
#pragma once
#include <malloc.h>
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <fstream>
#include <vector>

namespace scanmill::pipeline {

/// CPU seconds (user and system, all threads), wall seconds and peak memory between start and stop, one entry per use.
class Stopwatch {
 public:
  void start() {
    malloc_trim(0);                                 // what earlier stages freed is not this one's
    std::ofstream("/proc/self/clear_refs") << "5";  // the peak begins again; refused: it is that of the whole process
    cpu_ = cpu();
    wall_ = Clock::now();
  }
  void stop() {
    rusage use{};
    cpu_seconds.push_back(cpu(&use) - cpu_);
    wall_seconds.push_back(std::chrono::duration<double>(Clock::now() - wall_).count());
    peak_bytes = std::max(peak_bytes, static_cast<std::uint64_t>(use.ru_maxrss) * 1024);
  }
  std::vector<double> cpu_seconds, wall_seconds;
  std::uint64_t peak_bytes = 0;

 private:
  using Clock = std::chrono::steady_clock;
  static double cpu(rusage* out = nullptr) {
    rusage use{};
    getrusage(RUSAGE_SELF, &use);
    if (out) *out = use;
    const auto seconds = [](const timeval& t) {
      return static_cast<double>(t.tv_sec) + static_cast<double>(t.tv_usec) * 1e-6;
    };
    return seconds(use.ru_utime) + seconds(use.ru_stime);
  }
  double cpu_ = 0;
  Clock::time_point wall_;
};

}  // namespace scanmill::pipeline
