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

/// One 3DTK (slam6d) .pose file: x y z, then three angles in degrees, in its left-handed frame, where
/// p' = Rx Ry Rz p + t. Comes back for points whose z was negated, as a right-handed pose: M R M, M t with
/// M = diag(1, 1, -1); the scans land unmirrored in a right-handed global frame.
/// errors  BadInput with "file:line": other than six numbers
Result<Pose> read_3dtk_pose(const ByteSource& source);

}  // namespace scanmill::formats
