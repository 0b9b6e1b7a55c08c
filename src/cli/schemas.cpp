// SPDX-License-Identifier: Apache-2.0
#include "cli/schemas.hpp"

#include "base/text.hpp"
#include "document/read_fields.hpp"
#include "pipeline/what.hpp"
#include "runner/job.hpp"

namespace scanmill::cli {
namespace {

constexpr std::string_view kNames[] = {"job",    "plan",       "run",      "stream", "bench",  "throughput",
                                       "scale",  "journal",    "worklist", "tasks",  "result", "quarantine",
                                       "replay", "refinement", "truth",    "record"};

}  // namespace

std::span<const std::string_view> schema_names() { return kNames; }

Result<std::string> schema_text(const std::string& name) {
  if (name == "job") return document::to_json(runner::job_schema(pipeline::what_schema()), 2) + "\n";
  if (name == "plan") return std::string(k_plan_schema);
  if (name == "run") return std::string(k_run_schema);
  if (name == "stream") return std::string(k_stream_schema);
  if (name == "bench") return std::string(k_bench_schema);
  if (name == "journal") return std::string(k_journal_schema);
  if (name == "worklist") return std::string(k_worklist_schema);
  if (name == "tasks") return std::string(k_tasks_schema);
  if (name == "result") return std::string(k_result_schema);
  if (name == "quarantine") return std::string(k_quarantine_schema);
  if (name == "replay") return std::string(k_replay_schema);
  if (name == "refinement") return std::string(k_refinement_schema);
  if (name == "truth") return std::string(k_truth_schema);
  if (name == "record") return std::string(k_record_schema);
  if (name == "scale") return std::string(k_scale_schema);
  if (name == "throughput") return std::string(k_throughput_schema);
  std::string sentence = "schema: found " + name + "; allowed " + document::joined(kNames);
  if (const std::string_view nearest = nearest_name(name, kNames); !nearest.empty())
    sentence += "; nearest " + std::string(nearest);
  return fail(Code::BadUsage, sentence);
}

}  // namespace scanmill::cli
