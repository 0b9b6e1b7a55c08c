// SPDX-License-Identifier: Apache-2.0
// `scanmill task WORKLIST INDEX`: one task of a worklist file, by hand or by any engine. May run twice, or twice at
// once: what is done is not done again, attempts have folders of their own, and the first record stays.
#pragma once
#include <cstdint>
#include <string>

#include "runner/console.hpp"
#include "runner/driver.hpp"
#include "runner/task_file.hpp"
#include "runner/work.hpp"

namespace scanmill::runner {

struct TaskOptions {
  std::string path;  // of the worklist file
  std::size_t index = 0;
  std::string version;       // of this program
  std::int64_t threads = 0;  // 0: the task's
  std::uint64_t memory = 0;  // 0: the task's
};

inline constexpr const char* kDrainFile = "drain";      // in the worklist's folder: start no further scan
inline constexpr const char* kRevokedFile = "revoked";  // put nothing in place

/// Makes the scans of the task one after the other, each in a process of its own, and writes their records.
/// returns  0 all made or standing; 1 a process died, or records cannot be written; 2 no such task, or of another
///          version; 3 a scan failed for good; 4 a gate failed; 75 a passing fault, or what was left is no longer
///          wanted; 130, 143 stopped. Where several apply: 130/143, 1, 75, 3, 4.
int run_task(const TaskOptions& options, const TaskFile& file, Work& work, Console& console, Stop& stop);

}  // namespace scanmill::runner
