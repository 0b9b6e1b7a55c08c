// SPDX-License-Identifier: Apache-2.0
// First pass: the smallest interior angle of the two triangles grows. Internal to `optimise`.
#pragma once
#include "optimise/surface.hpp"

namespace scanmill::optimise {

/// Squared cosine of the smallest angle of a triangle with these squared sides, in [1/4, 1]; 1 when a side is zero. The
/// same bits in any order of the sides.
inline double smallest_angle_cos2(double x, double y, double z) {
  // The smallest angle lies between the two longer sides.
  const double low = x < y ? x : y, high = x < y ? y : x;
  const double least = low < z ? low : z, middle = low < z ? z : low;  // of the two left over, the one beside high
  if (!(least > 0)) return 1;
  const double twice = (middle + high) - least;
  return twice * twice / (4 * (middle * high));
}

/// Potential: the vector of all triangles' smallest angles, sorted; every swap raises it.
class SmoothRule {
 public:
  explicit SmoothRule(const Surface& surface) : surface_(surface) {}

  /// Fall of the squared cosine of the quad's smallest angle.
  double gain(std::uint32_t half) const {
    constexpr double kLeast = 1e-9;
    const Quad q = surface_.quad(half);
    const Vec3 a = surface_.at(q.a), b = surface_.at(q.b), c = surface_.at(q.c), d = surface_.at(q.d);
    const double ab = norm2(a - b), cd = norm2(c - d), bc = norm2(b - c), ca = norm2(c - a), ad = norm2(a - d),
                 db = norm2(d - b);
    const double s = smallest_angle_cos2(ab, bc, ca), t = smallest_angle_cos2(ab, ad, db);
    const double u = smallest_angle_cos2(cd, db, bc), v = smallest_angle_cos2(cd, ca, ad);
    const double gain = (s > t ? s : t) - (u > v ? u : v);
    return gain > kLeast ? gain : 0;
  }
  Vec3 normal(std::uint32_t slot) const { return surface_.normal(slot); }
  void swapped(const Quad&) {}

 private:
  const Surface& surface_;
};

}  // namespace scanmill::optimise
