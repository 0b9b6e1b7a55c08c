// SPDX-License-Identifier: Apache-2.0
// What a run found out, as the record keeps it.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "pipeline/scan_results.hpp"
#include "provenance/record.hpp"

namespace scanmill::pipeline {

/// What the stages found; without what the job asks of files and sections (finish_scan adds that). The record refers to
/// the mesh of `results`.
/// errors  what reading the description (plan, .conf) reports
Result<provenance::Record> record_of(const ScanResults& results);

/// The plan or .conf of a scan, as its record holds it.
Result<void> add_description(const std::string& archive, const ScanSpec& scan, provenance::Record& record);

/// A counter or figure of a record; 0 where the stage did not run.
double figure(const provenance::Record& record, std::string_view stage, std::string_view name);
std::uint64_t count(const provenance::Record& record, std::string_view stage, std::string_view name);
bool has_figure(const provenance::Record& record, std::string_view stage, std::string_view name);
void set_figure(provenance::Record& record, std::string_view stage, std::string_view name, double value);

/// Names of reduce::Drop, by number.
std::vector<std::string> drop_names();

}  // namespace scanmill::pipeline
