// SPDX-License-Identifier: Apache-2.0
// Scan plans from and to the files of other programs, and stations worked out for a machine.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "pipeline/tools.hpp"
#include "plan/plan.hpp"

namespace scanmill::pipeline {

/// Bytes of a plan; what is longer is something else.
inline constexpr std::uint64_t kLongestPlan = 64 << 20;

struct ImportChoice {
  std::string machine;                // plan whose machine and sensor are taken over; empty: none
  std::string units;                  // of the data files; empty: guessed from the size of the first view
  std::string files;                  // pattern of the data files where the poses name none, e.g. 'depth/*.png'
  std::int64_t every = 1;             // of the views the first, and every so many
  std::string intrinsics;             // fx,fy,cx,cy of depth maps
  std::optional<double> depth_scale;  // pixel values per unit
  bool hash = false;                  // add the SHA-256 of every view
};

/// .conf, .aln, .log, .xf and text of 4x4 matrices, PTX, 3DTK .pose, and LinuxCNC .ini as a scan plan, to `output` or,
/// when that is empty, as the report's text. Files are named relative to the folder of `output` (of the first input
/// without it), inside which they must lie.
Result<ToolReport> import_plan(const std::vector<std::string>& inputs, const ImportChoice& choice,
                               const std::string& output, const Context& context, Progress& progress);

/// as: gcode, conf, aln, log, xf, 3dtk (a folder of .pose files).
Result<ToolReport> export_plan(const std::string& path, const std::string& as, const std::string& output);

/// Every station of the plan (poses, targets, joints) as joints and counts of its machine, or of `machine`'s.
/// errors  BadParameter with every station that is unreachable, the joint and the limit that forbids it
Result<ToolReport> solve_plan(const std::string& path, const std::string& machine, const std::string& output);

/// A plan from its file; what is wrong with the text is BadParameter.
Result<plan::ScanPlan> load_plan(const std::string& path);
/// To `output`, or as the report's text when that is empty. `comments` stand on top, a line each.
Result<void> hand_over_plan(const plan::ScanPlan& plan, const std::vector<std::string>& comments,
                            const std::string& output, ToolReport& report);

}  // namespace scanmill::pipeline
