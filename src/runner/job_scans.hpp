// SPDX-License-Identifier: Apache-2.0
// The scans a job selects from its archive, each with the complete keys it is made with.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "runner/job.hpp"
#include "runner/work.hpp"

namespace scanmill::runner {

struct SelectedScan {
  std::size_t number = 0;  // in the archive
  ScanTask task;
  std::shared_ptr<const document::Node> what;  // resolved; scans with the same keys share one
};

struct Selection {
  std::vector<SelectedScan> scans;     // ascending by name
  std::vector<std::string> all_names;  // of the archive, selected or not
  std::vector<std::string> notes;      // of the archive as a whole, and idle
  std::vector<std::string> idle;       // patterns of the job or of --only that match no scan, a sentence each
};

/// Reads the file and the keys.
/// errors  BadParameter, all problems at once; BadInput when there is no such file
Result<Job> load_job(const std::string& path, std::span<const std::string> sets, const Work& work);

/// errors  BadParameter: no scan is selected, a scan's keys do not fit together (all at once); what discovery reports
Result<Selection> select_scans(const Job& job, std::span<const std::string> only, Work& work);

}  // namespace scanmill::runner
