// SPDX-License-Identifier: Apache-2.0
// What a run leaves behind for people and programs, beside run.json.
#pragma once
#include <string>
#include <vector>

#include "document/document.hpp"
#include "runner/night.hpp"
#include "runner/output_tree.hpp"
#include "runner/run_report.hpp"
#include "runner/work.hpp"

namespace scanmill::runner {

/// Writes report.html (where the work has one), junit.xml, trace.tsv and scanmill.prom into the tree, each complete and
/// synced under its final name; appends to the file that $GITHUB_STEP_SUMMARY names; keeps the figures for the next
/// run. A run told --only leaves the files of an earlier run as they are. To be called once, with the exit code known,
/// by the holder of the tree's lock.
///
/// last_night  load_night() from before, or nullptr
/// notes       gets a sentence for what could not be done outside of the tree
/// errors      NoSpace, IoFailed naming the first file of the tree that could not be written; all others were
Result<void> write_run_files(const RunReport& report, const LastNight* last_night, const Work& work,
                             const OutputTree& tree, std::vector<std::string>& notes);

/// The same with what load_night() finds.
Result<void> write_run_files(const RunReport& report, const Work& work, const OutputTree& tree,
                             std::vector<std::string>& notes);

}  // namespace scanmill::runner
