// SPDX-License-Identifier: Apache-2.0
// Files named on the command line as one scan.
#pragma once
#include <initializer_list>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "pipeline/discovery.hpp"
#include "pipeline/scan_points.hpp"
#include "pipeline/what.hpp"

namespace scanmill::pipeline {

struct ToolInput {
  std::string archive;  // folder that the scan's paths are relative to
  ScanSpec scan;
  std::string typed;  // what stands before those paths in the words of the command line
};

/// A failure that names a file of the scan, or nothing, names it as the command line does.
Error as_typed(Error error, const ToolInput& input);

/// One .conf or scan plan as the scan it describes, or any number of cloud files as the views of one scan without
/// poses.
/// errors  BadUsage for no input or a description among several; what reading the description reports
Result<ToolInput> scan_of_files(const std::vector<std::string>& paths);

struct OpenedInputs {
  ToolInput input;
  std::unique_ptr<ScanPoints> points;
};
/// The inputs of a tool as one cloud, with units, format and camera of `what`.
Result<OpenedInputs> open_inputs(const std::vector<std::string>& inputs, const What& what);

/// An output never takes the place of an input, and its suffix is one that the command writes.
/// errors  BadUsage
Result<void> check_output(const std::string& output, std::initializer_list<std::string_view> suffixes,
                          const std::vector<std::string>& inputs);

/// For reports: [x, y, z], and lines.
document::Node triple(Vec3 p);
document::Node texts(const std::vector<std::string>& lines);

}  // namespace scanmill::pipeline
