// SPDX-License-Identifier: Apache-2.0
// The job file: which scans, *what* to make of them (a tree that the pipeline judges), and *how* to run.
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "document/document.hpp"
#include "runner/cluster_keys.hpp"
#include "runner/notify.hpp"
#include "runner/work.hpp"

namespace scanmill::runner {

/// Nothing of this changes a byte of mesh or record.
struct How {
  std::int64_t threads = 0;      // 0: all the process may use
  std::uint64_t memory = 0;      // cap in bytes; 0: 80 % of the machine's
  bool strict = false;           // scans that were quarantined by an earlier run make this one fail too
  bool in_this_process = false;  // executor: inline
  bool on_cluster = false;       // executor: slurm
  ClusterKeys cluster;
  BrickKeys brick;             // scans that are cut into tasks
  std::int64_t settle_s = 60;  // files changed less than this ago may still be written
  double scan_time_limit_s = 6 * 3600;
  std::int64_t until_minute = -1;    // of the day, local time: nothing is started that would not end by then
  std::uint64_t disk = 0;            // bytes the run may use; 0: 80 % of what is free
  std::int64_t retry_transient = 2;  // further attempts after a fault that may pass
  std::int64_t retry_internal = 1;   // and after a crash
  double retry_wait_s = 2;           // before the first of them; four times as long before each next
  std::vector<NotifyRule> notify;
};

struct Override {
  std::vector<std::string> scans;  // globs
  document::Node what;
};

struct Job {
  std::string path;                 // as the user gave it
  std::string text;                 // as written
  std::string archive;              // folder, resolved against the job file's
  document::Mark archive_mark;      // where the job names it
  std::vector<std::string> scans;   // globs; empty: all
  document::Node what;              // what keys of the top level
  std::vector<Override> overrides;  // in order; later wins
  How how;
};

/// Reads a job. `sets` are "key.path=value" from the command line: how keys replace the job's, what keys become the
/// last override for all scans.
/// errors  BadParameter, all problems at once, a line each
Result<Job> job_from(const std::string& text, const std::string& path, std::span<const std::string> sets,
                     const Work& work);

/// The tree of one scan: the job's what keys with the overrides that match, in order.
document::Node what_of(const Job& job, const std::string& scan, const Work& work);

/// Draft-07 schema of a job file; `what_properties` are the schemas of the what keys.
document::Node job_schema(const document::Node& what_properties);

/// Discovery uses these what keys when it looks at the archive as a whole: no override may hold them.
bool is_whole_archive_key(std::string_view key);
/// The words that `executor` takes.
std::span<const std::string_view> executor_words();
/// The tables behind `resources` and `retry` and their schemas.
std::span<const Field> resource_fields();
std::span<const Field> retry_fields();
std::span<const Field> brick_fields();
const Field& settle_field();
/// 90, "90s", "15m", "6h", "1d" as seconds.
std::optional<double> parse_duration(std::string_view text);
/// "05:30" as minutes of the day.
std::optional<std::int64_t> parse_time_of_day(std::string_view text);

}  // namespace scanmill::runner
