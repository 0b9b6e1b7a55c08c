// SPDX-License-Identifier: Apache-2.0
// What `scanmill bench` found: as a document, as a table, and against an earlier one.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "document/document.hpp"
#include "timing/band.hpp"

namespace scanmill::pipeline {

using BenchBand = timing::Band;
using timing::band_of;
using timing::kSlower;

struct BenchStage {
  std::string name, unit;    // unit of the amount: "points", "kept points", "edges", "triangles"
  std::uint64_t amount = 0;  // what one repeat works on
  BenchBand cpu_s, wall_s;
  std::uint64_t peak_bytes = 0;  // greatest resident memory of the process in this stage, inputs included

  double per_cpu_s() const;
};

struct BenchInput {
  std::string name;     // path as given; empty for the cloud the bench makes
  std::string profile;  // of the job's words
  std::uint64_t points = 0, bins = 0, kept = 0, triangles = 0;
  double bin_mm = 0;
};

struct BenchReport {
  std::string version, processor;
  std::int64_t cores = 1, threads = 1, repeats = 1;
  BenchInput input;
  std::vector<BenchStage> stages;  // in the order of the flow
};

/// As schemas/bench.schema.json says.
document::Node to_document(const BenchStage& stage);
document::Node to_document(const BenchReport& report);
/// Reads what to_document made; `name` is the file, for messages.
/// errors  BadParameter naming the key that is missing or wrong
Result<BenchReport> bench_report_from(const document::Node& root, const std::string& name);

/// Beyond the noise: the least CPU time now is more than kSlower times the greatest then.
bool is_slower(const BenchStage& now, const BenchStage& then);
/// Two benches compare only over the same input: points, bin and profile.
/// errors  BadUsage saying what differs, with `name` as place
Result<void> check_same_input(const BenchInput& now, const BenchInput& then, const std::string& name);

struct BenchComparison {
  std::vector<std::string> slowdowns;  // a sentence per stage that is slower
  std::vector<std::string> notes;      // stages on one side only, another machine or number of threads
};
BenchComparison compare(const BenchReport& now, const BenchReport& then);
const BenchStage* stage_named(const BenchReport& report, const std::string& name);

/// For people; `then` may be null.
std::string bench_table(const BenchReport& report, const BenchReport* then);

}  // namespace scanmill::pipeline
