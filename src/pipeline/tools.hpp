// SPDX-License-Identifier: Apache-2.0
// Single stages on files: the same code as run_scan, without archive and output tree.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "base/context.hpp"
#include "base/progress.hpp"
#include "base/result.hpp"
#include "document/document.hpp"
#include "pipeline/what.hpp"

namespace scanmill::pipeline {

/// What a tool found out, as a map in the order of showing; values are scalars, lists of scalars, or maps of them.
struct ToolReport {
  document::Node values = document::Node::map();
  std::string text;                       // for people, in place of the values; empty: the values, a line each
  std::vector<std::string> failed_gates;  // one sentence each: exit code 4
};

/// Posed and reduced points of all inputs (cloud files, .conf, plans) as PLY with lattice and moments, what `mesh
/// --as-is` takes.
Result<ToolReport> reduce_to_file(const std::vector<std::string>& inputs, const What& what, const std::string& output,
                                  const Context& context, Progress& progress);
/// Mesh of the inputs as STL. `as_is`: the one input was written by `reduce`; its points are meshed as they are, its
/// lattice is taken when `what` gives no bin size.
Result<ToolReport> mesh_to_file(const std::vector<std::string>& inputs, const What& what, bool as_is,
                                const std::string& output, const Context& context, Progress& progress);
/// Format, points, bounds, spacing, noise, suggested bin.
Result<ToolReport> cloud_info(const std::string& input, const What& what, const Context& context, Progress& progress);
/// All points of a cloud file, .conf or plan, posed, mm, float64 PLY.
Result<ToolReport> convert_cloud(const std::string& input, const What& what, const std::string& output,
                                 const Context& context, Progress& progress);
/// A commented job for an archive, written to `output`, which must not be there yet.
Result<ToolReport> write_first_job(const std::string& archive, const std::string& output, const Context& context,
                                   Progress& progress);

}  // namespace scanmill::pipeline
