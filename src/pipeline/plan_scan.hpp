// SPDX-License-Identifier: Apache-2.0
// A scan plan as a scan of an archive.
#pragma once
#include <string>

#include "pipeline/scan_spec.hpp"
#include "plan/plan.hpp"

namespace scanmill::pipeline {

/// Views, units and sensor of the plan; `scan.description` is the plan's path, relative to the archive.
void views_of_plan(const plan::ScanPlan& plan, ScanSpec& scan);

/// What the machine says about the stations: warnings become notes, errors make the scan broken, a line each.
void judge_plan(const plan::ScanPlan& plan, ScanSpec& scan);

/// "a/b.yaml" -> "a/"
std::string folder_of(const std::string& path);

}  // namespace scanmill::pipeline
