// SPDX-License-Identifier: Apache-2.0
// Distances of simple solids and the operations that join them. Only + - * / and sqrt.
#pragma once
#include <algorithm>
#include <cmath>

#include "geom/vec3.hpp"

namespace scanmill::simulate {

inline double sphere(Vec3 p, Vec3 centre, double radius) { return norm(p - centre) - radius; }

/// A segment from `a` along the unit axis x (or y) of the given length, thickened by `radius`.
inline double capsule_x(Vec3 p, Vec3 a, double length, double radius) {
  p = p - a;
  p.x -= std::clamp(p.x, 0.0, length);
  return norm(p) - radius;
}
/// The same along y, symmetric about `centre`.
inline double capsule_y(Vec3 p, Vec3 centre, double half_length, double radius) {
  p = p - centre;
  p.y -= std::clamp(p.y, -half_length, half_length);
  return norm(p) - radius;
}

/// Axis-parallel box about `centre`; exact on both sides.
inline double box(Vec3 p, Vec3 centre, Vec3 half) {
  const Vec3 q{std::abs(p.x - centre.x) - half.x, std::abs(p.y - centre.y) - half.y, std::abs(p.z - centre.z) - half.z};
  const Vec3 out{std::max(q.x, 0.0), std::max(q.y, 0.0), std::max(q.z, 0.0)};
  return norm(out) + std::min(std::max(q.x, std::max(q.y, q.z)), 0.0);
}

/// Upright cylinder about `centre`; exact on both sides.
inline double cylinder_z(Vec3 p, Vec3 centre, double radius, double half_height) {
  const double x = p.x - centre.x, y = p.y - centre.y;
  const double side = std::sqrt(x * x + y * y) - radius, cap = std::abs(p.z - centre.z) - half_height;
  const double a = std::max(side, 0.0), b = std::max(cap, 0.0);
  return std::sqrt(a * a + b * b) + std::min(std::max(side, cap), 0.0);
}

/// Union with a round fillet where the two fields differ by less than `k` (radius about 0.7 k in a right angle). The
/// result's gradient is a mean of the two gradients with weights that sum to 1, so a Lipschitz constant of 1 survives.
inline double smooth_union(double a, double b, double k) {
  const double h = std::max(k - std::abs(a - b), 0.0);
  return std::min(a, b) - h * h * (0.25 / k);  // the compiler divides, k being a constant
}
/// `a` without `b`, the edge rounded likewise.
inline double smooth_cut(double a, double b, double k) { return -smooth_union(-a, b, k); }

}  // namespace scanmill::simulate
