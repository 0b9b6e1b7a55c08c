// SPDX-License-Identifier: Apache-2.0
#include "pipeline/views.hpp"

#include <algorithm>
#include <map>

#include "base/text.hpp"
#include "formats/probe.hpp"

namespace scanmill::pipeline {
namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }

std::string folder_of(const std::string& path) {
  const auto slash = path.rfind('/');
  return slash == std::string::npos ? std::string() : path.substr(0, slash + 1);
}

/// Poses by the path their names stand for.
std::map<std::string, Pose> by_path(const ViewsSpec& spec, const std::vector<formats::NamedPose>& poses) {
  std::map<std::string, Pose> paths;
  for (const formats::NamedPose& pose : poses) paths[plain_path(folder_of(spec.poses) + pose.name)] = pose.pose;
  return paths;
}

/// Poses of the files, in the files' order; what does not fit goes to `broken`.
std::vector<Pose> poses_of(const ViewsSpec& spec, const std::vector<std::string>& files,
                           const std::vector<formats::NamedPose>& poses, std::string& broken) {
  const std::string counts = std::to_string(files.size()) + (files.size() == 1 ? " file matches '" : " files match '") +
                             spec.files + "', " + spec.poses + " holds " + counted(poses.size(), "pose");
  std::vector<Pose> found;
  if (poses.empty() || poses.front().name.empty()) {
    if (poses.size() != files.size())
      broken = counts + "; wanted one pose per file";
    else
      for (const formats::NamedPose& pose : poses) found.push_back(pose.pose);
    return found;
  }
  const auto paths = by_path(spec, poses);
  for (const std::string& file : files) {
    const auto at = paths.find(file);
    if (at == paths.end()) {
      broken = counts + ", none of them for " + file;
      return {};
    }
    found.push_back(at->second);
  }
  return found;
}

/// Several views without a pose lie in one frame only if somebody put them there; depth maps never do.
void say_when_stacked(const ViewsSpec& spec, ScanSpec& scan) {
  if (scan.views.size() < 2 || !spec.poses.empty() || spec.pose) return;
  const auto has_own_pose = [](const ViewSpec& view) { return formats::suffix_of(view.path) == "ptx"; };
  if (std::all_of(scan.views.begin(), scan.views.end(), has_own_pose)) return;
  const std::string count = std::to_string(scan.views.size());
  if (spec.camera)
    scan.broken = "views." + spec.name + ": found " + count +
                  " depth maps and no poses; each lies in the frame of its own camera: name their poses (poses: "
                  "trajectory.log), or take one map";
  else
    scan.notes.push_back(count +
                         " views and no pose: all are taken to lie in one frame already; if each has its own, name "
                         "their poses (views: poses)");
}

}  // namespace

std::string plain_path(const std::string& path) {
  std::string out;
  for (std::size_t at = 0; at < path.size();) {
    const std::size_t end = std::min(path.find('/', at), path.size());
    const std::string part = path.substr(at, end - at);
    if (!part.empty() && part != ".") out.append(out.empty() ? "" : "/").append(part);
    at = end + 1;
  }
  return out;
}

bool natural_before(const std::string& a, const std::string& b) {
  std::size_t i = 0, j = 0;
  while (i < a.size() && j < b.size()) {
    if (!is_digit(a[i]) || !is_digit(b[j])) {
      if (a[i] != b[j]) return static_cast<unsigned char>(a[i]) < static_cast<unsigned char>(b[j]);
      ++i;
      ++j;
      continue;
    }
    while (i < a.size() && a[i] == '0') ++i;
    while (j < b.size() && b[j] == '0') ++j;
    const std::size_t a_begin = i, b_begin = j;
    while (i < a.size() && is_digit(a[i])) ++i;
    while (j < b.size() && is_digit(b[j])) ++j;
    if (i - a_begin != j - b_begin) return i - a_begin < j - b_begin;
    const int order = a.compare(a_begin, i - a_begin, b, b_begin, j - b_begin);
    if (order != 0) return order < 0;
  }
  if (i < a.size() || j < b.size()) return i == a.size();
  return a < b;
}

ScanSpec scan_of_views(const ViewsSpec& spec, const std::vector<std::string>& files,
                       const Result<std::vector<formats::NamedPose>>& poses, std::vector<std::string>& matched) {
  ScanSpec scan;
  scan.name = spec.name;
  scan.kind = ScanKind::Views;
  scan.description = spec.poses;
  for (const std::string& file : files)
    if (file != spec.poses && matches_pattern(spec.files, file)) matched.push_back(file);
  std::sort(matched.begin(), matched.end(), natural_before);
  const std::string place = "views." + spec.name + ": ";
  if (matched.empty()) {
    const std::vector<std::string_view> words(files.begin(), files.end());
    const std::string_view nearest = nearest_name(spec.files, words);
    scan.broken = place + "found no file of the archive that matches '" + spec.files + "'" +
                  (nearest.empty() ? "" : "; nearest " + std::string(nearest));
    return scan;
  }
  std::vector<Pose> found;
  if (!spec.poses.empty()) {
    if (!poses.ok()) {
      scan.broken = place + poses.error().text();
      return scan;
    }
    std::string broken;
    found = poses_of(spec, matched, *poses, broken);
    if (!broken.empty()) {
      scan.broken = place + broken;
      return scan;
    }
  }
  const auto given = spec.pose ? pose_from_matrix(*spec.pose) : Result<Pose>(Pose{});
  for (std::size_t k = 0; k < matched.size(); k += static_cast<std::size_t>(spec.every)) {
    ViewSpec& view = scan.views.emplace_back();
    view.path = matched[k];
    view.pose = !found.empty() ? found[k] : given.ok() ? *given : Pose{};
    view.pose_in_file_units = true;
    view.view_point.eye = spec.eye;
    view.camera = spec.camera;
  }
  say_when_stacked(spec, scan);
  std::sort(scan.views.begin(), scan.views.end(), [](const ViewSpec& a, const ViewSpec& b) { return a.path < b.path; });
  return scan;
}

}  // namespace scanmill::pipeline
