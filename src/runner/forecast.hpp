// SPDX-License-Identifier: Apache-2.0
// What a run would do, before it does it: scans, bytes, memory, time; as lines and as a graph of tasks.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "document/document.hpp"
#include "runner/run_report.hpp"
#include "runner/work.hpp"

namespace scanmill::runner {

/// Parts of a cut scan that are made at the same time.
struct ForecastWave {
  std::string kind;                     // "map"; the last is the scan itself
  std::uint64_t tasks = 1, memory = 0;  // memory: that each is given at least
  std::uint64_t disk = 0;               // of all parts that are there then
  double cpu = 0;                       // CPU time, of 1 for the scan
};

struct ForecastTask {
  std::string scan;
  std::string verb;  // run, unchanged, quarantined or broken
  std::vector<std::string> why;
  std::uint64_t bytes = 0;   // of input
  std::uint64_t memory = 0;  // that it is given at least
  std::vector<ForecastWave> waves = {};

  std::uint64_t disk() const;  // greatest of the waves
};

struct Forecast {
  std::vector<ForecastTask> tasks;
  double bytes_per_core_second = 0;  // of earlier runs in the output tree; 0: nothing known
  int cores = 1;

  std::uint64_t count(const std::string& verb) const;
  std::uint64_t bytes() const;                                                   // of the tasks that run
  std::uint64_t memory() const;                                                  // of the greatest of them
  double seconds() const;                                                        // 0: nothing known
  double cpu_seconds(const ForecastTask& task, const ForecastWave& wave) const;  // 0: nothing known
};

/// Kinds and numbers of the parts, with what each of them will take.
std::vector<ForecastWave> waves_of(const CutParts& parts, const CutForecast& forecast, std::uint64_t bytes);
document::Node to_document(const CutForecast& forecast);
CutForecast cut_forecast_from(const document::Node& tree);
/// "map", of "map 3".
std::string kind_of_part(const std::string& part);

/// Input that a core got through per second, from the last journals; 0 when they say nothing.
double speed_of(const std::string& journal_folder);
std::string line_of(const Forecast& forecast);
/// A scan's waves, a line each under a head; empty when it is made in one piece.
std::string table_of(const Forecast& forecast, const ForecastTask& task);
/// The worklist (schemas/worklist.schema.json), on one line.
document::Node to_document(const Forecast& forecast);
/// The same as a graph for `dot`: inputs and scans; dashed is what needs no work.
std::string to_dot(const Forecast& forecast);

}  // namespace scanmill::runner
