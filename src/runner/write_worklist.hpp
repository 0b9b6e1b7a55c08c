// SPDX-License-Identifier: Apache-2.0
// `scanmill worklist JOB`: what a run would make, as a worklist file for engines that this program does not drive.
#pragma once
#include <cstdint>
#include <string>

#include "runner/console.hpp"
#include "runner/driver.hpp"

namespace scanmill::runner {

struct WorklistOptions {
  RunOptions run;          // job, out, only, sets, threads and memory of a task, version
  std::string path;        // to write; empty: OUT/work/by-hand/tasks.json
  std::int64_t tasks = 0;  // at most; 0: by the forecast
};

/// Scans that need work, in tasks of about equal time. Results appear beside the file; a run of the job afterwards
/// finds them and writes the reports. returns  the exit code; 75 when a run holds the output, or tasks of an earlier
/// worklist are at work
int write_worklist(const WorklistOptions& options, Work& work, Console& console);

}  // namespace scanmill::runner
