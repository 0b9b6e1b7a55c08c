// SPDX-License-Identifier: Apache-2.0
// Rigid transforms from a view's frame to the global frame.
#pragma once
#include <array>

#include "base/result.hpp"
#include "geom/vec3.hpp"

namespace scanmill {

/// p_global = R p_view + t; R orthonormal, right-handed; t in mm.
struct Pose {
  std::array<double, 9> rotation{1, 0, 0, 0, 1, 0, 0, 0, 1};  // row-major
  Vec3 translation;

  Vec3 turn(Vec3 d) const {
    const auto& r = rotation;
    return {r[0] * d.x + r[1] * d.y + r[2] * d.z, r[3] * d.x + r[4] * d.y + r[5] * d.z,
            r[6] * d.x + r[7] * d.y + r[8] * d.z};
  }
  Vec3 apply(Vec3 p) const { return turn(p) + translation; }
  Pose inverse() const;
  /// this after `first`
  Pose after(const Pose& first) const;
  /// Row-major 4x4, last row 0 0 0 1.
  std::array<double, 16> matrix() const;
  friend bool operator==(const Pose&, const Pose&) = default;
};

/// Unit quaternion in the usual (Hamilton) sense, p' = q p q*; normalised here.
/// errors  BadInput when all four are zero or one is not finite
Result<Pose> pose_from_quaternion(double x, double y, double z, double w, Vec3 translation);
/// Row-major 4x4.
/// errors  BadInput when the last row is not 0 0 0 1, the rotation is mirrored, or off orthonormal by more than 1e-3;
///         smaller deviations are removed (Gram-Schmidt over the columns, so a second pass changes nothing beyond
///         rounding)
Result<Pose> pose_from_matrix(const std::array<double, 16>& m);
/// Camera at `eye` whose +z axis looks at `target`, +x as level as `up` allows (x = up x z).
Pose pose_looking_at(Vec3 eye, Vec3 target, Vec3 up);

/// Turn by an angle about an axis through the origin (right-hand rule); the axis need not be a unit vector.
Pose pose_turned(Vec3 axis, double degrees);
/// About the fixed x axis first, then y, then z, then moved: R = Rz Ry Rx.
Pose pose_from_angles(Vec3 degrees, Vec3 translation);
/// Shift without turn.
Pose pose_shifted(Vec3 translation);
/// x, y, z, w of the rotation, p' = q p q*; of the two signs the one with w >= 0.
std::array<double, 4> quaternion_of(const Pose& pose);

/// How far two poses lie apart.
struct PoseGap {
  double mm = 0, degrees = 0;
};
PoseGap gap_between(const Pose& a, const Pose& b);

}  // namespace scanmill
