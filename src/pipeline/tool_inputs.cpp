// SPDX-License-Identifier: Apache-2.0
#include "pipeline/tool_inputs.hpp"

#include <algorithm>
#include <filesystem>

#include "store/files.hpp"

namespace scanmill::pipeline {
namespace {

namespace fs = std::filesystem;

bool is_description(const fs::path& path) {
  const std::string suffix = path.extension().string();
  return suffix == ".conf" || suffix == ".aln" || suffix == ".yaml" || suffix == ".yml" || suffix == ".json";
}

Result<ToolInput> scan_of_description(const fs::path& path) {
  ToolInput input;
  input.archive = path.parent_path().string();
  const std::string name = path.filename().string();
  TRY_ASSIGN(Discovery found, discover(input.archive, true));
  for (ScanSpec& scan : found.scans)
    if (scan.description == name) {
      if (!scan.broken.empty()) return fail(Code::BadInput, scan.broken, name);
      input.scan = std::move(scan);
      return input;
    }
  return fail(Code::BadInput, "is neither a Stanford .conf or MeshLab .aln nor a scan plan (scanmill_plan: 1 on top)",
              path.string());
}

}  // namespace

Result<ToolInput> scan_of_files(const std::vector<std::string>& paths) {
  if (paths.empty()) return fail(Code::BadUsage, "no input file given");
  std::error_code ignored;
  std::vector<fs::path> files;
  for (const std::string& path : paths) {
    TRY(store::open_file(path, path));  // the first that is not there is told as the user wrote it
    files.push_back(fs::absolute(path, ignored).lexically_normal());
  }
  const bool described = std::any_of(files.begin(), files.end(), is_description);
  if (described && files.size() > 1)
    return fail(Code::BadUsage, "a .conf or scan plan is a whole scan and must be the only input");
  if (described) return scan_of_description(files.front());
  fs::path common = files.front().parent_path();
  for (const fs::path& file : files)
    while (file.lexically_relative(common).native().rfind("..", 0) == 0) common = common.parent_path();
  ToolInput input;
  input.archive = common.string();
  input.scan.name = files.front().stem().string();
  for (const fs::path& file : files) {
    ViewSpec view;
    view.path = file.lexically_relative(common).generic_string();
    input.scan.views.push_back(std::move(view));
  }
  std::sort(input.scan.views.begin(), input.scan.views.end(),
            [](const ViewSpec& a, const ViewSpec& b) { return a.path < b.path; });
  return input;
}

}  // namespace scanmill::pipeline
