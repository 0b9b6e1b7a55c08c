// SPDX-License-Identifier: Apache-2.0
// What a run found out, as the record keeps it.
#pragma once
#include <string>
#include <vector>

#include "pipeline/clean_scan.hpp"
#include "pipeline/discovery.hpp"
#include "pipeline/scan_points.hpp"
#include "pipeline/surface.hpp"
#include "pipeline/what.hpp"
#include "provenance/record.hpp"
#include "reduce/reduce.hpp"

namespace scanmill::pipeline {

/// `digests`: SHA-256 of each view of `points`. The record refers to `surface.mesh`.
/// errors  what reading the description (plan, .conf) reports
Result<provenance::Record> record_of(const std::string& archive, const ScanSpec& scan, const What& what,
                                     const ScanPoints& points, const CleanedScan& cleaned,
                                     const std::vector<std::string>& digests, const reduce::Reduction& reduction,
                                     const MeshedSurface& surface, const std::vector<std::string>& notes,
                                     const std::string& stl_digest);

/// Names of reduce::Drop, by number.
std::vector<std::string> drop_names();

}  // namespace scanmill::pipeline
