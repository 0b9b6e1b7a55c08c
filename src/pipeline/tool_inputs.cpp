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

Result<ToolInput> scan_of_description(const fs::path& path, const std::string& typed) {
  ToolInput input;
  input.archive = path.parent_path().string();
  input.typed = typed.substr(0, typed.size() - path.filename().string().size());
  const std::string name = path.filename().string();
  TRY_ASSIGN(Discovery found, discover(input.archive, true));
  for (ScanSpec& scan : found.scans)
    if (scan.description == name) {
      if (scan.broken.starts_with(name + ": ")) scan.broken.erase(0, name.size() + 2);
      if (!scan.broken.empty()) return fail(Code::BadInput, scan.broken, input.typed + name);
      input.scan = std::move(scan);
      return input;
    }
  return fail(Code::BadInput, "is neither a Stanford .conf or MeshLab .aln nor a scan plan (scanmill_plan: 1 on top)",
              path.string());
}

/// "a/b.ply" and places in it: "a/b.ply:9".
bool is_of(const std::string& where, const std::string& path) {
  return !path.empty() && where.starts_with(path) && (where.size() == path.size() || where[path.size()] == ':');
}

}  // namespace

Error as_typed(Error error, const ToolInput& input) {
  const ScanSpec& scan = input.scan;
  if (error.where.empty() || error.where == scan.name) {
    if (!scan.description.empty())
      error.where = scan.description;
    else if (!scan.views.empty())
      error.where = scan.views.front().path;
  } else if (!is_of(error.where, scan.description) &&
             std::none_of(scan.views.begin(), scan.views.end(),
                          [&](const ViewSpec& view) { return is_of(error.where, view.path); }))
    return error;
  error.where.insert(0, input.typed);
  return error;
}

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
  if (described) return scan_of_description(files.front(), paths.front());
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
  const std::string& first = input.scan.views.front().path;
  if (paths.front().ends_with(first)) input.typed = paths.front().substr(0, paths.front().size() - first.size());
  std::sort(input.scan.views.begin(), input.scan.views.end(),
            [](const ViewSpec& a, const ViewSpec& b) { return a.path < b.path; });
  return input;
}

Result<OpenedInputs> open_inputs(const std::vector<std::string>& inputs, const What& what) {
  OpenedInputs opened;
  TRY_ASSIGN(opened.input, scan_of_files(inputs));
  for (ViewSpec& view : opened.input.scan.views)
    if (!view.camera) view.camera = what.camera;
  auto points = ScanPoints::open(opened.input.archive, opened.input.scan, what.units_mm, what.format);
  if (!points.ok()) return as_typed(std::move(points).error(), opened.input);
  opened.points = std::move(points).value();
  return opened;
}

Result<void> check_output(const std::string& output, std::initializer_list<std::string_view> suffixes,
                          const std::vector<std::string>& inputs) {
  const std::string suffix = fs::path(output).extension().string();
  if (std::find(suffixes.begin(), suffixes.end(), suffix) == suffixes.end()) {
    std::string allowed;
    for (const std::string_view word : suffixes) allowed += (allowed.empty() ? "" : ", ") + std::string(word);
    return fail(Code::BadUsage, "found this output name; this command writes " + allowed + " files only", output);
  }
  std::error_code ignored;
  for (const std::string& input : inputs)
    if (fs::equivalent(output, input, ignored))
      return fail(Code::BadUsage, "is an input as well; name another file, nothing was written", output);
  return {};
}

document::Node triple(Vec3 p) {
  document::Node list = document::Node::sequence();
  for (const double value : {p.x, p.y, p.z}) list.push(value);
  return list;
}

document::Node texts(const std::vector<std::string>& lines) {
  document::Node list = document::Node::sequence();
  for (const std::string& line : lines) list.push(line);
  return list;
}

}  // namespace scanmill::pipeline
