// SPDX-License-Identifier: Apache-2.0
#include "geom/pose.hpp"

#include <algorithm>

#include "base/text.hpp"
#include "geom/angles.hpp"

namespace scanmill {

Pose Pose::inverse() const {
  const auto& r = rotation;
  Pose inverse;
  inverse.rotation = {r[0], r[3], r[6], r[1], r[4], r[7], r[2], r[5], r[8]};
  inverse.translation = -inverse.turn(translation);
  return inverse;
}

Pose Pose::after(const Pose& first) const {
  Pose out;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      out.rotation[i * 3 + j] = rotation[i * 3] * first.rotation[j] + rotation[i * 3 + 1] * first.rotation[3 + j] +
                                rotation[i * 3 + 2] * first.rotation[6 + j];
  out.translation = apply(first.translation);
  return out;
}

std::array<double, 16> Pose::matrix() const {
  const auto& r = rotation;
  const Vec3& t = translation;
  return {r[0], r[1], r[2], t.x, r[3], r[4], r[5], t.y, r[6], r[7], r[8], t.z, 0, 0, 0, 1};
}

Result<Pose> pose_from_quaternion(double x, double y, double z, double w, Vec3 translation) {
  const double length = std::sqrt(x * x + y * y + z * z + w * w);
  if (!(length > 0) || !std::isfinite(length) || !is_finite(translation))
    return fail(Code::BadInput, "a pose needs a finite quaternion that is not all zero and a finite translation");
  x /= length;
  y /= length;
  z /= length;
  w /= length;
  Pose pose;
  pose.rotation = {1 - 2 * (y * y + z * z), 2 * (x * y - z * w),     2 * (x * z + y * w),
                   2 * (x * y + z * w),     1 - 2 * (x * x + z * z), 2 * (y * z - x * w),
                   2 * (x * z - y * w),     2 * (y * z + x * w),     1 - 2 * (x * x + y * y)};
  pose.translation = translation;
  return pose;
}

Result<Pose> pose_from_matrix(const std::array<double, 16>& m) {
  for (const double value : m)
    if (!std::isfinite(value)) return fail(Code::BadInput, "a pose matrix holds a value that is not finite");
  if (std::abs(m[12]) > 1e-9 || std::abs(m[13]) > 1e-9 || std::abs(m[14]) > 1e-9 || std::abs(m[15] - 1) > 1e-9)
    return fail(Code::BadInput, "the last row of a pose matrix must be 0 0 0 1, found " + number_text(m[12]) + " " +
                                    number_text(m[13]) + " " + number_text(m[14]) + " " + number_text(m[15]) +
                                    "; is the matrix transposed?");
  Vec3 x{m[0], m[4], m[8]}, y{m[1], m[5], m[9]}, z{m[2], m[6], m[10]};
  const double off = std::abs(norm2(x) - 1) + std::abs(norm2(y) - 1) + std::abs(norm2(z) - 1) + std::abs(dot(x, y)) +
                     std::abs(dot(y, z)) + std::abs(dot(z, x));
  if (off > 1e-3)
    return fail(Code::BadInput, "the rotation of a pose matrix is off orthonormal by " + number_text(off) +
                                    " (allowed 0.001); scaling and shear are not poses");
  if (dot(cross(x, y), z) < 0)
    return fail(Code::BadInput, "the rotation of a pose matrix mirrors space (determinant -1)");
  x = unit(x);
  y = unit(y - x * dot(x, y));
  z = cross(x, y);
  Pose pose;
  pose.rotation = {x.x, y.x, z.x, x.y, y.y, z.y, x.z, y.z, z.z};
  pose.translation = {m[3], m[7], m[11]};
  return pose;
}

Pose pose_looking_at(Vec3 eye, Vec3 target, Vec3 up) {
  const Vec3 z = unit(target - eye);
  Vec3 side = cross(up, z);
  if (norm2(side) < 1e-12) side = cross(std::abs(z.x) < 0.9 ? Vec3{1, 0, 0} : Vec3{0, 1, 0}, z);
  const Vec3 x = unit(side), y = cross(z, x);
  Pose pose;
  pose.rotation = {x.x, y.x, z.x, x.y, y.y, z.y, x.z, y.z, z.z};
  pose.translation = eye;
  return pose;
}

Pose pose_turned(Vec3 axis, double degrees) {
  const Vec3 n = unit(axis);
  const auto [s, c] = sine_cosine_of(degrees);
  const double d = 1 - c;
  Pose pose;
  pose.rotation = {c + n.x * n.x * d,       n.x * n.y * d - n.z * s, n.x * n.z * d + n.y * s,
                   n.y * n.x * d + n.z * s, c + n.y * n.y * d,       n.y * n.z * d - n.x * s,
                   n.z * n.x * d - n.y * s, n.z * n.y * d + n.x * s, c + n.z * n.z * d};
  return pose;
}

Pose pose_from_angles(Vec3 degrees, Vec3 translation) {
  Pose pose = pose_turned({0, 0, 1}, degrees.z)
                  .after(pose_turned({0, 1, 0}, degrees.y))
                  .after(pose_turned({1, 0, 0}, degrees.x));
  pose.translation = translation;
  return pose;
}

Pose pose_shifted(Vec3 translation) {
  Pose pose;
  pose.translation = translation;
  return pose;
}

std::array<double, 4> quaternion_of(const Pose& pose) {
  const auto& r = pose.rotation;
  // Four times the squares of w, x, y, z: the largest is divided by, so nothing cancels.
  const std::array<double, 4> squares{1 + r[0] + r[4] + r[8], 1 + r[0] - r[4] - r[8], 1 - r[0] + r[4] - r[8],
                                      1 - r[0] - r[4] + r[8]};
  const auto largest = std::max_element(squares.begin(), squares.end()) - squares.begin();
  const double root = std::sqrt(squares[static_cast<std::size_t>(largest)]), k = 0.5 / root;
  double w = 0, x = 0, y = 0, z = 0;
  if (largest == 0) {
    w = root / 2, x = (r[7] - r[5]) * k, y = (r[2] - r[6]) * k, z = (r[3] - r[1]) * k;
  } else if (largest == 1) {
    w = (r[7] - r[5]) * k, x = root / 2, y = (r[1] + r[3]) * k, z = (r[2] + r[6]) * k;
  } else if (largest == 2) {
    w = (r[2] - r[6]) * k, x = (r[1] + r[3]) * k, y = root / 2, z = (r[5] + r[7]) * k;
  } else {
    w = (r[3] - r[1]) * k, x = (r[2] + r[6]) * k, y = (r[5] + r[7]) * k, z = root / 2;
  }
  const double sign = w < 0 ? -1 : 1;
  return {x * sign, y * sign, z * sign, w * sign};
}

PoseGap gap_between(const Pose& a, const Pose& b) {
  const Pose turn = a.inverse().after(b);
  const auto& r = turn.rotation;
  const Vec3 twice_sine{r[7] - r[5], r[2] - r[6], r[3] - r[1]};
  return {norm(a.translation - b.translation), degrees_of(norm(twice_sine), r[0] + r[4] + r[8] - 1)};
}

}  // namespace scanmill
