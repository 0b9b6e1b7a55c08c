// SPDX-License-Identifier: Apache-2.0
// The JSON Schemas of everything that users write or scripts read.
#pragma once
#include <span>
#include <string>
#include <string_view>

#include "base/result.hpp"

namespace scanmill::cli {

extern const char k_plan_schema[], k_run_schema[], k_stream_schema[], k_bench_schema[], k_throughput_schema[];
extern const char k_journal_schema[], k_worklist_schema[], k_quarantine_schema[], k_replay_schema[];
extern const char k_tasks_schema[], k_result_schema[];
extern const char k_journal_schema[], k_worklist_schema[], k_quarantine_schema[], k_refinement_schema[];
extern const char k_journal_schema[], k_worklist_schema[], k_quarantine_schema[], k_truth_schema[], k_record_schema[];
extern const char k_scale_schema[];

std::span<const std::string_view> schema_names();
/// Text of a schema, as in schemas/ of the source.
/// errors  BadUsage naming the schemas there are
Result<std::string> schema_text(const std::string& name);

}  // namespace scanmill::cli
