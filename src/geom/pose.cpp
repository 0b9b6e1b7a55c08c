// SPDX-License-Identifier: Apache-2.0
#include "geom/pose.hpp"

#include "base/text.hpp"

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

}  // namespace scanmill
