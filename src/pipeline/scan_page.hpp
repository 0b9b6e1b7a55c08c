// SPDX-License-Identifier: Apache-2.0
// The report of a scan, filled from what the stages found.
#pragma once
#include <string>
#include <utility>
#include <vector>

#include "pipeline/scan_results.hpp"
#include "report/scan_report.hpp"

namespace scanmill::pipeline {

/// What no stage knows: the job and program by name, when it was made and how long each stage took.
struct PageFrame {
  std::string job, tool, record, date;
  std::vector<std::pair<std::string, double>> stage_seconds;
};

report::ScanReport page_of(const ScanResults& results, std::vector<report::Picture> pictures,
                           std::vector<report::SectionRow> sections, const PageFrame& frame);

}  // namespace scanmill::pipeline
