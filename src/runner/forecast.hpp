// SPDX-License-Identifier: Apache-2.0
// What a run would do, before it does it: scans, bytes, memory, time; as lines and as a graph of tasks.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "document/document.hpp"
#include "runner/run_report.hpp"

namespace scanmill::runner {

struct ForecastTask {
  std::string scan;
  std::string verb;  // run, unchanged, quarantined or broken
  std::vector<std::string> why;
  std::uint64_t bytes = 0;   // of input
  std::uint64_t memory = 0;  // that it is given at least
};

struct Forecast {
  std::vector<ForecastTask> tasks;
  double bytes_per_core_second = 0;  // of earlier runs in the output tree; 0: nothing known
  int cores = 1;

  std::uint64_t count(const std::string& verb) const;
  std::uint64_t bytes() const;   // of the tasks that run
  std::uint64_t memory() const;  // of the greatest of them
  double seconds() const;        // 0: nothing known
};

/// Input that a core got through per second, from the last journals; 0 when they say nothing.
double speed_of(const std::string& journal_folder);
std::string line_of(const Forecast& forecast);
/// The worklist (schemas/worklist.schema.json), on one line.
document::Node to_document(const Forecast& forecast);
/// The same as a graph for `dot`: inputs and scans; dashed is what needs no work.
std::string to_dot(const Forecast& forecast);

}  // namespace scanmill::runner
