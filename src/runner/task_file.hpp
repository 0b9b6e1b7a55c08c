// SPDX-License-Identifier: Apache-2.0
// A worklist as a file: numbered tasks that any engine runs with `scanmill task FILE INDEX`. The file holds the job as
// it was written and the keys of every scan, so that a task makes exactly what the one who wrote the file decided.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "document/document.hpp"

namespace scanmill::runner {

inline constexpr const char* kTaskFileName = "tasks.json";

/// One scan of a task.
struct TaskItem {
  std::string scan;
  std::size_t keys = 0;     // place in TaskFile::keys
  std::uint64_t bytes = 0;  // of its inputs
  std::string part = {};    // of a scan that is cut; empty: the scan itself
};

/// What one process makes, one item after the other.
struct Task {
  int threads = 1;
  std::uint64_t memory = 0;  // cap of each item in bytes; 0: none
  int wave = 0;              // tasks of lesser waves come first
  std::vector<TaskItem> items;
};

struct TaskFile {
  std::string version;               // of the program; another one may make other bytes
  std::string token;                 // nobody else's: names jobs of a cluster
  std::string out;                   // output tree, absolute
  std::string job_path, job_text;    // absolute; the text as written
  std::string job_shown;             // the path as the user gave it, for reports
  std::vector<std::string> sets;     // key=value that replace the job's keys
  bool forced = false;               // scans are tried even when quarantined
  std::uint64_t memory_cap = 0;      // of the run, for the quarantine's entries
  double time_limit_s = 6 * 3600;    // of a scan
  double lease_s = 120;              // a task without a sign for so long counts as dead
  std::vector<document::Node> keys;  // resolved what keys; scans with the same ones share an entry
  std::vector<Task> tasks;
};

/// schemas/tasks.schema.json
document::Node to_document(const TaskFile& file);
/// errors  BadInput naming `path` and the key
Result<TaskFile> task_file_from(const document::Node& tree, const std::string& path);
/// errors  BadInput when it is not there or no worklist
Result<TaskFile> load_task_file(const std::string& path);
/// Eight hexadecimal digits that nobody else has.
std::string new_token();

}  // namespace scanmill::runner
