// SPDX-License-Identifier: Apache-2.0
// Entries of `views` for depth maps that nobody has described yet.
#pragma once
#include <string>
#include <vector>

#include "pipeline/views.hpp"

namespace scanmill::pipeline {

struct DepthViews {
  ViewsSpec spec;
  std::size_t files = 0;                // maps of the folder
  std::uint32_t width = 0, height = 0;  // of the first
  bool usual_camera = false;            // 640 x 480: the numbers are those such cameras have
};

/// One entry per folder of depth maps: its files, thinned to some fifty, the pose file beside them that holds as many
/// poses as there are maps, and the intrinsics a camera of this picture size usually has (PrimeSense and first Kinect:
/// 525 pixels of focal length at 640 x 480; others scaled from it, a guess for the user to mend).
/// maps     paths in the archive, ascending; all_files: every path in it
std::vector<DepthViews> guess_depth_views(const std::string& archive, const std::vector<std::string>& maps,
                                          const std::vector<std::string>& all_files);

/// The block `views:` of a job, commented.
std::string views_text(const std::vector<DepthViews>& list);

}  // namespace scanmill::pipeline
