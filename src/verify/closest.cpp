// SPDX-License-Identifier: Apache-2.0
#include "verify/closest.hpp"

namespace scanmill::verify {
namespace {

constexpr double kFlatSine2 = 1e-16;

struct OnSide {
  double distance2;
  int end;  // 0: at its begin, 1: at its end, 2: between
};
OnSide closest_on_side(Vec3 from_begin, Vec3 side) {
  const double along = dot(from_begin, side), length2 = norm2(side);
  if (!(along > 0)) return {norm2(from_begin), 0};
  if (along >= length2) return {norm2(from_begin - side), 1};
  return {norm2(from_begin - side * (along / length2)), 2};
}

Closest closest_on_sides(Vec3 p, Vec3 a, Vec3 b, Vec3 c) {
  static constexpr Feature kAt[3][3] = {{Feature::CornerA, Feature::CornerB, Feature::EdgeAB},
                                        {Feature::CornerB, Feature::CornerC, Feature::EdgeBC},
                                        {Feature::CornerC, Feature::CornerA, Feature::EdgeCA}};
  const OnSide sides[3] = {closest_on_side(p - a, b - a), closest_on_side(p - b, c - b), closest_on_side(p - c, a - c)};
  int best = 0;
  for (int k = 1; k < 3; ++k)
    if (sides[k].distance2 < sides[best].distance2) best = k;
  return {sides[best].distance2, kAt[best][sides[best].end]};
}

}  // namespace

Closest closest_on_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 ab = b - a, ac = c - a, ap = p - a, n = cross(ab, ac);
  const double n2 = norm2(n);
  if (!(n2 > kFlatSine2 * norm2(ab) * norm2(ac))) return closest_on_sides(p, a, b, c);
  const double d1 = dot(ab, ap), d2 = dot(ac, ap);
  if (d1 <= 0 && d2 <= 0) return {norm2(ap), Feature::CornerA};
  const Vec3 bp = p - b;
  const double d3 = dot(ab, bp), d4 = dot(ac, bp);
  if (d3 >= 0 && d4 <= d3) return {norm2(bp), Feature::CornerB};
  const Vec3 cp = p - c;
  const double d5 = dot(ab, cp), d6 = dot(ac, cp);
  if (d6 >= 0 && d5 <= d6) return {norm2(cp), Feature::CornerC};
  if (d1 * d4 - d3 * d2 <= 0 && d1 >= 0 && d3 <= 0) return {norm2(ap - ab * (d1 / (d1 - d3))), Feature::EdgeAB};
  if (d5 * d2 - d1 * d6 <= 0 && d2 >= 0 && d6 <= 0) return {norm2(ap - ac * (d2 / (d2 - d6))), Feature::EdgeCA};
  if (d3 * d6 - d5 * d4 <= 0 && d4 >= d3 && d5 >= d6)
    return {norm2(bp - (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)))), Feature::EdgeBC};
  const double height = dot(ap, n);
  return {height * height / n2, Feature::Face};
}

}  // namespace scanmill::verify
