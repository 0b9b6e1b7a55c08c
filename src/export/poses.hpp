// SPDX-License-Identifier: Apache-2.0
// Poses as the files other programs read; the counterparts of formats/poses.hpp.
#pragma once
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.hpp"
#include "geom/pose.hpp"

namespace scanmill::exporting {

struct PosedFile {
  std::string file;  // as the pose file shall name it
  Pose pose;         // view to global; translation in the files' units
};

/// Stanford .conf: `bmesh FILE tx ty tz qx qy qz qw` with the conjugate quaternion, p' = R(q)^T p + t.
/// errors  BadParameter for a file name with a blank, which the format cannot hold
Result<std::string> conf_text(std::span<const PosedFile> views);
/// MeshLab .aln: count, then name, #, four rows each, then 0.
std::string aln_text(std::span<const PosedFile> views);
/// Trajectory .log: "i i i+1" and four rows each.
std::string log_text(std::span<const PosedFile> views);
/// Four rows per view, one after the other (.xf, .txt).
std::string matrices_text(std::span<const PosedFile> views);
/// One 3DTK .pose file, for points whose z is negated (its frame is left-handed).
std::string dtk_text(const Pose& pose);

}  // namespace scanmill::exporting
