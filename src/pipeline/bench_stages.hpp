// SPDX-License-Identifier: Apache-2.0
// How fast is each stage, here and on these points: the calls of run_scan, one by one, repeated and timed.
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "pipeline/tools.hpp"

namespace scanmill::pipeline {

struct BenchChoice {
  std::string stage;         // a stage, "optimise" for both its passes, or empty for all
  std::string file;          // cloud file, .conf or plan; empty: a made sphere of a million points
  std::int64_t repeats = 5;  // 1 to 1000
  std::string against, out;  // documents: an earlier one to compare with, the one to write; or empty
  std::string version, processor;
  std::int64_t cores = 1;
};

/// Words that BenchChoice::stage takes.
std::span<const std::string_view> bench_stage_words();

/// Measures CPU time (user and system, all threads) and wall time of the stages reduce, mesh, smooth, feature, quality
/// and verify, in this order; with a stage named, those before it run once, unmeasured. Reading the file is part of
/// reduce and verify, as in a job; setting inputs up and freeing results is part of none. Without a bin size: the one
/// that `info` suggests for a file, 1 mm for the made cloud.
///
/// A stage that is slower than in `against` (is_slower) is measured as often again before it is believed; confirmed
/// ones are the report's failed gates.
/// errors  BadUsage for an unknown stage or an earlier document of another input; BadParameter for a document that is
/// none;
///         what the stages report; Cancelled
Result<ToolReport> bench_stages(const BenchChoice& choice, const What& what, const Context& context,
                                Progress& progress);

}  // namespace scanmill::pipeline
