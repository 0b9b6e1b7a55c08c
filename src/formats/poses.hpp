// SPDX-License-Identifier: Apache-2.0
// Files that say how views lie to each other.
#pragma once
#include <string>
#include <vector>

#include "base/bytes.hpp"
#include "geom/pose.hpp"

namespace scanmill::formats {

struct NamedPose {
  std::string name;  // file it belongs to, relative to the pose file's folder; empty: by order
  Pose pose;         // view to global; the translation is in the files' units
};

/// Told apart by content: Stanford .conf (bmesh lines), MeshLab .aln (a count, then per mesh a name, a # line and a
/// 4x4, then 0), trajectory .log (three whole numbers before each 4x4), and text of one or more 4x4 matrices (.xf,
/// .txt; four rows of four numbers, or sixteen numbers in a line). Matrices have the translation in the last column and
/// move view points to the global frame. errors  BadInput with "file:line": another line, a matrix that is cut or no
/// rigid pose, a count that does not match
Result<std::vector<NamedPose>> read_poses(const ByteSource& source);

}  // namespace scanmill::formats
