// SPDX-License-Identifier: Apache-2.0
// What an operator asks of an output tree from any shell: status, cancel, gc, retry.
#pragma once
#include <string>
#include <vector>

#include "base/result.hpp"
#include "runner/console.hpp"
#include "runner/driver.hpp"

namespace scanmill::runner {

/// What is going on, or how the last run ended; the exit code.
int show_status(const std::string& out, Console& console);
/// Asks the run that holds the tree to bring its scans to the end and stop; asked twice it stops at once.
int cancel_run(const std::string& out, Console& console);
/// Removes what dead runs left behind, old journals, and logs of scans that are gone. Takes the lock while it works.
int collect_garbage(const std::string& out, bool dry_run, Console& console);
/// True, after saying by whom, when a run holds the tree.
bool is_held(const std::string& out, Console& console);
/// Takes scans (patterns; all when there are none) out of quarantine. The options of a run that tries them, and
/// those that failed last time, again; `only` is empty when there is none.
/// errors  BadUsage: no run.json, a pattern that nothing matches
Result<RunOptions> release_scans(const std::string& out, const std::vector<std::string>& patterns, Console& console);

}  // namespace scanmill::runner
