// SPDX-License-Identifier: Apache-2.0
// How scans are put together to tasks: few enough that starting them costs nothing, many enough that all nodes have
// work.
#pragma once
#include <cstdint>
#include <vector>

namespace scanmill::runner {

struct ScanLoad {
  std::size_t scan = 0;
  double seconds = 0;  // forecast
};

struct PackRule {
  double task_seconds = 300;       // a task is meant to run for so long
  std::size_t least_tasks = 16;    // as far as there are scans
  std::size_t scans_per_task = 0;  // fixed; 0: by the forecast
};

/// Scans of each task, heaviest first, heaviest task first. Each scan goes to the task with the least to do; ties by
/// number. Cost O(n log n).
std::vector<std::vector<std::size_t>> pack_tasks(std::vector<ScanLoad> loads, const PackRule& rule);

/// Forecast of a scan on so many threads: at the speed of earlier runs, else at a careful guess.
double forecast_seconds(std::uint64_t bytes, double bytes_per_core_second, int threads);

/// A memory request that many scans share: the next of 1, 1.5, 2, 3, 4, 6, 8, ... times 128 MiB, `most` at most.
std::uint64_t memory_class(std::uint64_t bytes, std::uint64_t most);

}  // namespace scanmill::runner
