// SPDX-License-Identifier: Apache-2.0
// The occupied bins of a scan as OpenVDB grids.
#pragma once
#include <string>

#include "pipeline/scan_results.hpp"
#include "reduce/reduce.hpp"

namespace scanmill::pipeline {

/// Grids `points` (input points in the bin), `row` (of /reduced in the record) and `drop` (why its point is no vertex
/// candidate, 0 = kept), synced, read back and compared.
/// errors  those of write_bin_grids and of the sink
Result<WrittenFile> write_bins_file(const reduce::ReducedCloud& cloud, const std::string& path);

}  // namespace scanmill::pipeline
