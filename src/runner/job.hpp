// SPDX-License-Identifier: Apache-2.0
// The job file: which scans, *what* to make of them (a tree that the pipeline judges), and *how* to run.
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "document/document.hpp"
#include "runner/notify.hpp"
#include "runner/work.hpp"

namespace scanmill::runner {

/// Nothing of this changes a byte of mesh or record.
struct How {
  std::int64_t threads = 0;  // 0: all the process may use
  std::uint64_t memory = 0;  // cap in bytes; 0: 80 % of the machine's
  bool strict = false;       // scans that were quarantined by an earlier run make this one fail too
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

/// Discovery uses these what keys, and discovery looks at the archive as a whole: no override may hold them.
bool is_whole_archive_key(std::string_view key);
/// The words that `executor` takes.
std::span<const std::string_view> executor_words();
/// The table behind `resources` and its schema.
std::span<const Field> resource_fields();

}  // namespace scanmill::runner
