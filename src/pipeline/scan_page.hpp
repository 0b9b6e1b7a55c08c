// SPDX-License-Identifier: Apache-2.0
// The report of a scan, filled from what the stages found.
#pragma once
#include <string>
#include <utility>
#include <vector>

#include "pipeline/finish_scan.hpp"
#include "pipeline/scan_results.hpp"
#include "report/scan_report.hpp"

namespace scanmill::pipeline {

/// What no stage knows: the job and program by name, when it was made and how long each stage took.
struct PageFrame {
  std::string job, tool, record, date;
  std::vector<std::pair<std::string, double>> stage_seconds;
};

/// Says what the record says. `files`: the outputs beside it.
report::ScanReport page_of(const FinishedScan& scan, const What& what, const std::vector<WrittenFile>& files,
                           std::vector<report::Picture> pictures, std::vector<report::SectionRow> sections,
                           const PageFrame& frame);

}  // namespace scanmill::pipeline
