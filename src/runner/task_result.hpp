// SPDX-License-Identifier: Apache-2.0
// What a task leaves beside its worklist: a record per scan, the only truth about it, and a sign of life while it
// works. A record appears under its name complete and synced, or not at all.
#pragma once
#include <cstdint>
#include <optional>
#include <string>

#include "runner/executor.hpp"

namespace scanmill::runner {

struct TaskResult {
  std::string scan;
  std::string host, engine;  // where; the engine's own name of the task, such as a Slurm job
  Ended ended;               // its order is not part of the record
};

document::Node to_document(const TaskResult& result);
/// errors  Internal when the tree is no record
Result<TaskResult> task_result_from(const document::Node& tree);

/// "<folder>/<index>-<item>.json"
std::string result_path(const std::string& folder, std::size_t index, std::size_t item);
/// The two numbers of a record's file name; nothing for another name.
std::optional<std::pair<std::size_t, std::size_t>> result_numbers(const std::string& name);
/// Nothing more will come of the scan: it is made, stands, is held back, or its input is bad.
bool is_final(const TaskResult& result);
/// Puts the record in place. The first one stays when it is final: false then.
/// errors  IoFailed, NoSpace naming the file
Result<bool> save_result(const std::string& folder, std::size_t index, std::size_t item, const TaskResult& result);
/// Nothing while the record is not there or cannot be read (yet).
std::optional<TaskResult> load_result(const std::string& path);

/// What a task is at.
struct Heartbeat {
  std::string host, engine;
  int pid = 0;
  std::size_t item = 0;
  std::string stage;
  std::uint64_t done = 0, total = 0;
  std::string space = {};   // process_space() of the task: where its pid means anything
  std::uint64_t began = 0;  // ProcessSign::began
};
/// "<index>.<host>.<pid>.alive": two copies of a task do not write the same file.
std::string heartbeat_name(std::size_t index, const std::string& host, int pid);
/// The index in such a name; nothing for another name.
std::optional<std::size_t> heartbeat_index(const std::string& name);
/// A sign of life is the time of the file; what it says is for people.
void beat(const std::string& path, const Heartbeat& heartbeat);
std::optional<Heartbeat> load_heartbeat(const std::string& path);

}  // namespace scanmill::runner
