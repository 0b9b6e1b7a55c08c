// SPDX-License-Identifier: Apache-2.0
#include "runner/pack_tasks.hpp"

#include <algorithm>
#include <cmath>
#include <queue>

namespace scanmill::runner {
namespace {

constexpr double kBaseSeconds = 0.3;       // start of a process, record, pictures
constexpr double kUnknownSpeed = 1 << 20;  // bytes per core and second; measured 3 to 20 MB/s
constexpr std::uint64_t kLeastMemory = 128ull << 20;

}  // namespace

std::vector<std::vector<std::size_t>> pack_tasks(std::vector<ScanLoad> loads, const PackRule& rule) {
  if (loads.empty()) return {};
  double all = 0;
  for (const ScanLoad& load : loads) all += load.seconds;
  std::size_t count = static_cast<std::size_t>(std::ceil(all / std::max(1.0, rule.task_seconds)));
  count = std::max(count, rule.least_tasks);
  if (rule.scans_per_task > 0) count = (loads.size() + rule.scans_per_task - 1) / rule.scans_per_task;
  count = std::clamp<std::size_t>(count, 1, loads.size());
  std::sort(loads.begin(), loads.end(), [](const ScanLoad& a, const ScanLoad& b) {
    return a.seconds != b.seconds ? a.seconds > b.seconds : a.scan < b.scan;
  });
  struct Least {
    double seconds;
    std::size_t scans, task;
    bool operator<(const Least& other) const {  // the queue's top is the greatest
      if (seconds != other.seconds) return seconds > other.seconds;
      return scans != other.scans ? scans > other.scans : task > other.task;
    }
  };
  std::priority_queue<Least> queue;
  for (std::size_t task = 0; task < count; ++task) queue.push({0, 0, task});
  std::vector<std::vector<std::size_t>> tasks(count);
  std::vector<double> seconds(count);
  for (const ScanLoad& load : loads) {
    Least least = queue.top();
    queue.pop();
    tasks[least.task].push_back(load.scan);
    least.seconds += load.seconds;
    least.scans += 1;
    seconds[least.task] = least.seconds;
    if (rule.scans_per_task == 0 || least.scans < rule.scans_per_task) queue.push(least);
  }
  std::vector<std::size_t> order(count);
  for (std::size_t i = 0; i < count; ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return seconds[a] > seconds[b]; });
  std::vector<std::vector<std::size_t>> sorted;
  for (const std::size_t task : order) sorted.push_back(std::move(tasks[task]));
  return sorted;
}

double forecast_seconds(std::uint64_t bytes, double bytes_per_core_second, int threads) {
  const double speed = bytes_per_core_second > 0 ? bytes_per_core_second : kUnknownSpeed;
  return kBaseSeconds + static_cast<double>(bytes) / speed / std::max(1, threads);
}

std::uint64_t memory_class(std::uint64_t bytes, std::uint64_t most) {
  std::uint64_t size = kLeastMemory;
  while (size < bytes) {
    if (size / 2 * 3 >= bytes) {
      size = size / 2 * 3;
      break;
    }
    size *= 2;
  }
  return most > 0 ? std::min(size, most) : size;
}

}  // namespace scanmill::runner
