// SPDX-License-Identifier: Apache-2.0
// A scan plan rehearsed offline: the machine's motions, the points in their places, and everything that is wrong.
#pragma once
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/coverage.hpp"
#include "pipeline/tools.hpp"
#include "plan/motion.hpp"

namespace scanmill::pipeline {

struct ReplayChoice {
  std::optional<double> bin_mm;  // of the coverage; ten sensor pixels unless given, about 20,000 bins without a sensor
  bool no_cloud = false, no_pictures = false;
};

/// What is known of a plan once its views have been read.
struct Rehearsal {
  std::string path;
  plan::ScanPlan plan;
  plan::Replay replay;                   // with the findings of files and points
  std::vector<plan::Finding> elsewhere;  // findings of no single station
  std::size_t files_named = 0, files_there = 0;
  std::unique_ptr<ScanPoints> points;     // of the views that are there and sound; null without any
  std::vector<std::size_t> station_of;    // per view of points->views()
  std::optional<reduce::Reduction> bins;  // one measured point per bin
  std::optional<Coverage> coverage;
  bool has_errors() const { return replay.totals.errors > 0; }
  /// Texts of one severity in the order of the stations.
  std::vector<std::string> texts(plan::Severity severity) const;
};

/// Reads the plan, moves its machine, opens its views, compares hashes, and with `look` reads all points (depth band,
/// field, coverage).
/// errors  BadParameter for a plan that cannot be read; what is wrong with stations and views are findings, no errors
Result<Rehearsal> rehearse(const std::string& path, const ReplayChoice& choice, bool look, const Context& context,
                           Progress& progress);

/// replay.json (docs/plan.md).
document::Node replay_document(const Rehearsal& rehearsal);

/// `replay`: replay.json, timeline.tsv, cloud.ply, and the pictures machine.png, part.png, timeline.png in `folder`.
/// errors  BadParameter with every finding that is an error, after the files were written
Result<ToolReport> replay_plan(const std::string& path, const std::string& folder, const ReplayChoice& choice,
                               const Context& context, Progress& progress);

/// `check` of a plan: the same without files. A plan none of whose views is there yet is sound.
Result<ToolReport> check_plan(const std::string& path, const Context& context, Progress& progress);

}  // namespace scanmill::pipeline
