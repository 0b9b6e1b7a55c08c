// SPDX-License-Identifier: Apache-2.0
// ro-crate-metadata.json: what an archive's catalogue reads of a run (RO-Crate 1.1, Process Run Crate 0.5).
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "base/bytes.hpp"
#include "base/context.hpp"
#include "runner/run_report.hpp"
#include "runner/scan_state.hpp"

namespace scanmill::runner {

/// A result that stands.
struct CrateScan {
  std::string name;
  bool made_now = false;  // by this run, so its times are the action's
  ScanState state;
};

/// The result of a scan of the report, if there is one.
using ResultOf = FunctionRef<std::optional<CrateScan>(const ScanEntry&)>;

/// The JSON text, an entity a line: one CreateAction per scan with its inputs and outputs, all with SHA-256 and size;
/// paths are relative to the output tree. `files_of_run`: others of the tree, by name. One result at a time is in
/// memory, and the names of all files (60 bytes each).
/// errors  those of the sink, which is not committed
Result<void> write_ro_crate(const RunReport& report, ResultOf result_of, const std::vector<std::string>& files_of_run,
                            ByteSink& sink);

}  // namespace scanmill::runner
