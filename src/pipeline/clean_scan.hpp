// SPDX-License-Identifier: Apache-2.0
// The `clean` stage of one scan: rules fixed, blocks filtered, what went told.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "base/progress.hpp"
#include "clean/clean.hpp"
#include "pipeline/what.hpp"
#include "provenance/record.hpp"

namespace scanmill::pipeline {

struct CleanedScan {
  const PointSource* points = nullptr;          // what the next stage reads
  std::unique_ptr<clean::CleanPoints> cleaned;  // null without rules: the points are those that were given
};

/// `points` outlives the result.
/// errors  those of clean::fix_rules
Result<CleanedScan> clean_scan(const PointSource& points, const What& what, const Context& context, Progress& progress);

/// The error of a stage behind; where the rules left no point at all it says so instead.
Error explained(Error error, const CleanedScan& scan);

/// Names of the counters in the record, by clean::Rule.
inline constexpr const char* kCleanCounters[clean::kRules] = {"kept",
                                                              "removed_keep_box",
                                                              "removed_remove_box",
                                                              "removed_on_plane",
                                                              "removed_below_plane",
                                                              "removed_statistical",
                                                              "removed_component"};

/// Once every block has been read: sentences for the user, counters, and the inputs' numbers of points that are used.
void add_clean_notes(const CleanedScan& scan, std::vector<std::string>& notes);
void add_clean_counters(const CleanedScan& scan, provenance::Record& record);

}  // namespace scanmill::pipeline
