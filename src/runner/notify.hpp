// SPDX-License-Identifier: Apache-2.0
// Commands that the job wants run when a run has ended: mail, a chat message, a copy of the results.
#pragma once
#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

#include "document/document.hpp"
#include "document/read_fields.hpp"
#include "runner/output_tree.hpp"
#include "runner/run_report.hpp"

namespace scanmill::runner {

enum class NotifyOn : std::int32_t { Always, Failure, Success };

/// An entry of `notify`. Failure is every exit code but 0, an interruption too.
struct NotifyRule {
  NotifyOn on = NotifyOn::Always;
  std::string run;  // for /bin/sh
};

/// Reads the value of the job's key `notify`, a list of {on, run}.
void read_notify(const document::Node& value, std::vector<NotifyRule>& rules, document::Problems& problems);
/// Draft-07 schema of the same.
document::Node notify_schema();

/// A command that takes longer is ended, with everything it started.
inline constexpr std::chrono::milliseconds kNotifyLimit{60000};

/// Runs the commands that the exit code of `report` calls for, one after the other, each in the folder of the job file,
/// with SCANMILL_RUN (path of run.json; empty when none was written), SCANMILL_EXIT, SCANMILL_OUT, SCANMILL_SUMMARY
/// (the last line) and SCANMILL_VERDICT in its environment, nothing on stdin, and what it prints in
/// OUT/journal/notify.log. Never fails: a sentence for each command that could not be run, failed or was ended.
std::vector<std::string> notify(const std::vector<NotifyRule>& rules, const RunReport& report, const OutputTree& tree,
                                std::chrono::milliseconds limit = kNotifyLimit);

}  // namespace scanmill::runner
