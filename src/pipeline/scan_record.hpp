// SPDX-License-Identifier: Apache-2.0
// What a run found out, as the record keeps it.
#pragma once
#include <string>
#include <vector>

#include "pipeline/scan_results.hpp"
#include "provenance/record.hpp"

namespace scanmill::pipeline {

/// The record refers to the mesh of `results`.
/// errors  what reading the description (plan, .conf) reports
Result<provenance::Record> record_of(const ScanResults& results);

/// Names of reduce::Drop, by number.
std::vector<std::string> drop_names();

}  // namespace scanmill::pipeline
