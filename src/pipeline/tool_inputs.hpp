// SPDX-License-Identifier: Apache-2.0
// Files named on the command line as one scan.
#pragma once
#include <string>
#include <vector>

#include "pipeline/discovery.hpp"

namespace scanmill::pipeline {

struct ToolInput {
  std::string archive;  // folder that the scan's paths are relative to
  ScanSpec scan;
};

/// One .conf or scan plan as the scan it describes, or any number of cloud files as the views of one scan without
/// poses.
/// errors  BadUsage for no input or a description among several; what reading the description reports
Result<ToolInput> scan_of_files(const std::vector<std::string>& paths);

}  // namespace scanmill::pipeline
