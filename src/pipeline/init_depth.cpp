// SPDX-License-Identifier: Apache-2.0
#include "pipeline/init_depth.hpp"

#include <algorithm>
#include <filesystem>
#include <map>

#include "base/text.hpp"
#include "document/document.hpp"
#include "formats/png.hpp"
#include "formats/poses.hpp"
#include "formats/probe.hpp"
#include "pipeline/plan_scan.hpp"
#include "store/files.hpp"

namespace scanmill::pipeline {
namespace {

constexpr std::size_t kFewFrames = 50;  // neighbouring frames of a film show the same
constexpr double kFocalAt640 = 525;     // pixels; PrimeSense and first Kinect

/// "depth/0" of "depth/00000.png", "depth/00210.png": what every path begins with.
std::string common_start(const std::vector<std::string>& paths) {
  std::string start = paths.front();
  for (const std::string& path : paths)
    start.resize(static_cast<std::size_t>(std::mismatch(start.begin(), start.end(), path.begin(), path.end()).first -
                                          start.begin()));
  return start;
}

/// The pattern of a folder's maps: all PNGs, unless others lie there too.
std::string pattern_of(const std::string& folder, const std::vector<std::string>& maps,
                       const std::vector<std::string>& all_files) {
  const auto pictures = std::count_if(all_files.begin(), all_files.end(), [&](const std::string& file) {
    return file.starts_with(folder) && formats::suffix_of(file) == "png";
  });
  const std::string end = maps.front().substr(maps.front().rfind('.'));
  return (static_cast<std::size_t>(pictures) == maps.size() ? folder : common_start(maps)) + "*" + end;
}

/// The file beside the maps, or a folder above, that holds as many poses; empty when there is none.
std::string poses_beside(const std::string& archive, const std::string& folder, std::size_t count,
                         const std::vector<std::string>& all_files) {
  for (const std::string& file : all_files) {
    const std::string suffix = formats::suffix_of(file);
    const bool may_be = suffix == "log" || suffix == "txt" || suffix == "xf" || suffix == "pose" || suffix == "traj";
    if (!may_be || !folder.starts_with(folder_of(file))) continue;
    const auto source = store::open_file(archive + "/" + file, file);
    const auto poses =
        source.ok() ? formats::read_poses(**source) : Result<std::vector<formats::NamedPose>>(source.error());
    if (poses.ok() && poses->size() == count) return file;
  }
  return {};
}

DepthViews guess_one(const std::string& archive, const std::string& folder, const std::vector<std::string>& maps,
                     const std::vector<std::string>& all_files) {
  DepthViews guess;
  guess.files = maps.size();
  guess.spec.name = folder.empty() ? std::filesystem::absolute(archive).lexically_normal().filename().string()
                                   : folder.substr(0, folder.size() - 1);
  if (guess.spec.name.empty() || guess.spec.name == ".") guess.spec.name = "depth";
  guess.spec.files = pattern_of(folder, maps, all_files);
  guess.spec.every = static_cast<std::int64_t>((maps.size() + kFewFrames - 1) / kFewFrames);
  guess.spec.poses = poses_beside(archive, folder, maps.size(), all_files);
  if (const auto source = store::open_file(archive + "/" + maps.front(), maps.front()); source.ok())
    if (const auto png = formats::open_png(**source); png.ok()) {
      guess.width = png->width;
      guess.height = png->height;
    }
  guess.usual_camera = guess.width == 640 && guess.height == 480;
  const double focal = kFocalAt640 * guess.width / 640;
  guess.spec.camera = formats::DepthCamera{focal, focal, (guess.width - 1) / 2.0, (guess.height - 1) / 2.0, 1000};
  return guess;
}

std::string quoted(const std::string& word) { return document::to_json(document::Node(word)); }

}  // namespace

std::vector<DepthViews> guess_depth_views(const std::string& archive, const std::vector<std::string>& maps,
                                          const std::vector<std::string>& all_files) {
  std::map<std::string, std::vector<std::string>> folders;
  for (const std::string& map : maps) folders[folder_of(map)].push_back(map);
  std::vector<DepthViews> list;
  for (const auto& [folder, files] : folders) list.push_back(guess_one(archive, folder, files, all_files));
  return list;
}

std::string views_text(const std::vector<DepthViews>& list) {
  std::string text =
      "\n# Depth maps do not say how their camera sees. The intrinsics (fx, fy, cx, cy in pixels) below are guessed "
      "from "
      "the\n# size of the pictures, and 1000 steps a metre assumed: put in your camera's numbers.\nviews:\n";
  for (const DepthViews& guess : list) {
    const formats::DepthCamera& camera = *guess.spec.camera;
    text += "  - name: " + quoted(guess.spec.name) + "\n    files: " + quoted(guess.spec.files) + "  # " +
            counted(guess.files, "file") + " of " + std::to_string(guess.width) + " x " + std::to_string(guess.height) +
            "\n";
    if (guess.spec.every > 1) text += "    every: " + std::to_string(guess.spec.every) + "\n";
    text += guess.spec.poses.empty() ? "    # poses: FILE  # none was found with " + counted(guess.files, "pose") +
                                           ": without, all maps are taken to lie in one frame\n"
                                     : "    poses: " + quoted(guess.spec.poses) + "\n";
    text += "    intrinsics: [" + number_text(camera.fx) + ", " + number_text(camera.fy) + ", " +
            number_text(camera.cx) + ", " + number_text(camera.cy) + "]" +
            (guess.usual_camera ? "  # PrimeSense, first Kinect" : "  # a guess") +
            "\n    depth_scale: " + number_text(camera.depth_scale) + "\n";
  }
  return text;
}

}  // namespace scanmill::pipeline
