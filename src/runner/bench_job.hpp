// SPDX-License-Identifier: Apache-2.0
// How many scans an hour a job makes on this machine: the whole job, repeated at every number of threads.
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "base/result.hpp"
#include "document/document.hpp"
#include "runner/console.hpp"
#include "runner/driver.hpp"
#include "runner/work.hpp"
#include "timing/band.hpp"

namespace scanmill::runner {

struct BenchJobOptions {
  std::string job;
  std::string against, out;  // documents: an earlier one to compare with, the one to write; or empty
  std::int64_t repeats = 5;
  std::int64_t threads = 0;  // greatest number; 0: all the process may use
  std::uint64_t memory = 0;  // 0: the job's
  std::string version;
  document::Node libraries = document::Node::map();
  std::function<std::unique_ptr<Work>()> work;  // fresh for every run
};

/// One number of threads.
struct JobTiming {
  int threads = 1;
  timing::Band cpu_s, wall_s;  // of a whole run
  // CPU seconds over those of the yardstick just before and after: what the work costs, whatever the machine did at the
  // time. --against judges the median.
  timing::Band yardsticks;
  std::uint64_t peak_bytes = 0;
  std::vector<std::pair<std::string, timing::Band>> stages;  // wall seconds, summed over the scans

  double scans_per_hour(std::uint64_t scans) const;
};

struct JobBench {
  std::string version, processor, job;
  std::int64_t cores = 1, repeats = 1;
  std::uint64_t scans = 0, points = 0, bins = 0;
  timing::Band yardstick_s;
  std::vector<JobTiming> runs;  // by number of threads
};

/// As schemas/throughput.schema.json says.
document::Node to_document(const JobBench& bench);
/// errors  BadParameter naming the key that is missing or wrong
Result<JobBench> job_bench_from(const document::Node& root, const std::string& name);

/// Beyond the noise: the median cost in yardsticks is more than this factor times what it was. Measured under four
/// times as much load as cores, medians of five repeats of an unchanged build lie within 1.15 of one another.
inline constexpr double kJobSlower = 1.15;
/// And so is the least cost, by this factor: beside compilers the median of an unchanged build came to 1.18 times, its
/// least to 0.99.
inline constexpr double kLeastSlower = 1.05;
bool is_slower(const JobTiming& now, const JobTiming& then);

/// "1, 2, 4, ..., n": every number up to four, then doubling, n last.
std::vector<int> thread_counts(int greatest);

/// Runs the job once unmeasured, then `repeats` times at each number of threads in turn, every time into a fresh
/// output tree below the folder for temporary files, without its notify commands; shows the figures and writes the
/// document. A number of threads that looks slower than in `against` is measured again, up to four more rounds, with
/// all others; what still looks slower then is a confirmed slowdown.
/// Exit codes: 0; 4 with a confirmed slowdown; that of a run whose scans do not all pass; 2 for documents that do not
/// fit; 130, 143 when interrupted.
int bench_job(const BenchJobOptions& options, Console& console, Stop& stop);

}  // namespace scanmill::runner
