// SPDX-License-Identifier: Apache-2.0
// First pass: the smallest interior angle of the two triangles grows. Internal to `optimise`.
#pragma once
#include <vector>

#include "base/context.hpp"
#include "optimise/surface.hpp"

namespace scanmill::optimise {

/// Squared cosine of the smallest angle of a triangle with these squared sides, in [1/4, 1]; 1 when a side is zero. The
/// same bits in any order of the sides: the angle lies between the two longer ones.
inline double smallest_angle_cos2(double x, double y, double z) {
  const double least = x < y ? (x < z ? x : z) : (y < z ? y : z);
  const double most = x > y ? (x > z ? x : z) : (y > z ? y : z);
  const double middle = x == least ? (y == most ? z : y) : y == least ? (x == most ? z : x) : (x == most ? y : x);
  if (!(least > 0)) return 1;
  const double twice = (middle + most) - least;
  return twice * twice / (4 * middle * most);
}

/// Potential: the vector of all triangles' smallest angles, sorted; every swap raises it.
class SmoothRule {
 public:
  SmoothRule(const Surface& surface, const Context& context);

  /// Fall of the squared cosine of the quad's smallest angle.
  double gain(std::uint32_t half) const;
  Vec3 normal(std::uint32_t slot) const;
  void swapped(const Quad& quad);

  /// Per slot.
  const std::vector<double>& cos2() const { return cos2_; }

 private:
  double cos2_of(std::uint32_t slot) const;

  const Surface& surface_;
  std::vector<double> cos2_;
};

}  // namespace scanmill::optimise
