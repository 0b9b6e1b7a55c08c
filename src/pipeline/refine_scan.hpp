// SPDX-License-Identifier: Apache-2.0
// The `refine` stage of one scan: views moved before anything else sees their points.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "base/progress.hpp"
#include "pipeline/scan_points.hpp"
#include "pipeline/scan_results.hpp"
#include "pipeline/what.hpp"
#include "provenance/record.hpp"
#include "refine/refine.hpp"

namespace scanmill::pipeline {

struct RefinedScan {
  std::optional<refine::Report> report;  // empty when the job does not ask for it
  std::vector<Pose> told, poses;         // by view id: as the machine says, and as used
  refine::Accuracy accuracy;
  bool on_datum = false;  // keep_out bodies hold the whole
};

/// Poses of `points` are what the machine says before, and the refined ones after.
/// errors  BadParameter when neither job nor plan say how accurate the machine is, or no body is known for `datum`;
/// those
///         of refine_poses
Result<RefinedScan> refine_scan(ScanPoints& points, const ScanSpec& scan, const What& what, const Context& context,
                                Progress& progress);

/// One sentence, and one per view held at its limit.
void add_refine_notes(const RefinedScan& refined, const ScanPoints& points, std::vector<std::string>& notes);
/// Counters and the group /refinement.
void add_refinement(const RefinedScan& refined, const ScanPoints& points, provenance::Record& record);
/// refinement.json: every view's motion, every pair's gaps.
Result<WrittenFile> write_refinement(const RefinedScan& refined, const ScanPoints& points, const std::string& folder);

}  // namespace scanmill::pipeline
