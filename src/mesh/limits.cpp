// SPDX-License-Identifier: Apache-2.0
#include "mesh/limits.hpp"

#include <cmath>

namespace scanmill {

namespace {
constexpr std::string_view kEngines[] = {"stars", "front"};
}

std::span<const Field> GrowthLimits::fields() {
  static const Field kTable[] = {
      field<GrowthLimits, &GrowthLimits::range_bins>(
          "range_bins", "g1", "Longest edge of a triangle, in bin edges; wider gaps stay open.", {0, 2.5, true}),
      field<GrowthLimits, &GrowthLimits::min_angle_deg>("min_angle_deg", "g2", "Smallest interior angle of a triangle.",
                                                        {0, 45}),
      field<GrowthLimits, &GrowthLimits::min_normal_dot>(
          "min_normal_dot", "g3", "Least cosine between the normals of neighbouring triangles of one patch.",
          {-1, 0.9999}),
      field<GrowthLimits, &GrowthLimits::max_normal_deg>(
          "max_normal_deg", "g3", "The same limit as an angle; wins over min_normal_dot.", {0.9, 180}),
      field<GrowthLimits, &GrowthLimits::engine>(
          "engine", "", "stars: confirmed stars; front: the paper's growth taken literally, up to 50,000 points.", {},
          kEngines),
  };
  return kTable;
}

double GrowthLimits::normal_dot() const { return max_normal_deg ? cos_of_degrees(*max_normal_deg) : min_normal_dot; }

bool within_range(Vec3 a, Vec3 b, Vec3 c, double range) {
  const double limit = range * range;
  return norm2(a - b) <= limit && norm2(b - c) <= limit && norm2(c - a) <= limit;
}

bool angles_at_least(Vec3 a, Vec3 b, Vec3 c, double cos_min_angle) {
  auto wide_enough = [&](Vec3 u, Vec3 v) {
    const double d = dot(u, v);
    return d <= 0 || d * d <= cos_min_angle * cos_min_angle * (norm2(u) * norm2(v));
  };
  return wide_enough(b - a, c - a) && wide_enough(a - b, c - b) && wide_enough(a - c, b - c);
}

double cos_of_degrees(double degrees) {
  double x = std::fmod(std::abs(degrees), 360.0);  // exact
  if (x > 180) x = 360 - x;
  const bool negative = x > 90;
  if (negative) x = 180 - x;
  const double r = x * 0.017453292519943295;
  const double s = r * r;
  double sum = 0;
  for (int n = 22; n >= 0; n -= 2) sum = 1 - sum * s / ((n + 1) * (n + 2));  // Horner form of the cosine series
  return negative ? -sum : sum;
}

}  // namespace scanmill
