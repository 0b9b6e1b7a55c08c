// SPDX-License-Identifier: Apache-2.0
// First crossing of a ray with an object's surface.
#pragma once
#include "simulate/object.hpp"

namespace scanmill::simulate {

struct Ray {
  Vec3 origin, direction;  // direction is a unit vector
  Vec3 at(double t) const { return origin + direction * t; }
};

struct Interval {
  double low, high;
};

/// Where the ray is inside the box; empty (low > high) when it misses.
Interval clip(const Ray& ray, const Bounds& box);

/// The least t in `range` where `side` * distance falls to zero, or a value beyond range.high. `side` is 1 to look for
/// the surface from outside and -1 from inside. |distance| <= 1e-9 there, unless the ray only grazes (then <= 1e-7).
double first_crossing(const Object& object, const Ray& ray, Interval range, double side);

}  // namespace scanmill::simulate
