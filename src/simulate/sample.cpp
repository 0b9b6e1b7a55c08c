// SPDX-License-Identifier: Apache-2.0
// Points uniform by area, for any solid with a distance: by Crofton's formula every piece of surface is crossed by
// uniform random lines in proportion to its area, whatever its slope.
#include "base/random.hpp"
#include "simulate/trace.hpp"

namespace scanmill::simulate {
namespace {

constexpr std::uint64_t kLinePurpose = 0x6c696e65;  // "line"

Vec3 direction(Random& random) {
  for (;;) {
    const Vec3 d{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
    if (const double n = norm2(d); n <= 1 && n > 1e-4) return unit(d);
  }
}

/// A line through the ball: uniform direction, uniform foot in the disc across it.
Ray line_through(Vec3 centre, double radius, Random& random) {
  const Vec3 d = direction(random);
  const Vec3 u = unit(cross(std::abs(d.x) < 0.7 ? Vec3{1, 0, 0} : Vec3{0, 1, 0}, d)), v = cross(d, u);
  for (;;) {
    const double a = random.uniform(-1, 1), b = random.uniform(-1, 1);
    if (a * a + b * b <= 1) return {centre + u * (a * radius) + v * (b * radius) - d * radius, d};
  }
}

}  // namespace

std::vector<Vec3> sample_surface(const Object& object, std::size_t count, std::uint64_t seed) {
  constexpr double kSkip = 1e-6;  // mm past a crossing, to leave it behind
  const Bounds box = object.bounds();
  const Vec3 centre = (box.low + box.high) * 0.5;
  const double radius = norm(box.size()) * 0.5 + 0.01;
  std::vector<Vec3> points;
  points.reserve(count);
  for (std::uint64_t line = 0; points.size() < count; ++line) {
    Random random(seed, line, kLinePurpose);
    const Ray ray = line_through(centre, radius, random);
    double t = 0;
    while (t < 2 * radius && points.size() < count) {
      const double side = object.distance(ray.at(t)) >= 0 ? 1 : -1;
      t = first_crossing(object, ray, {t, 2 * radius}, side);
      if (t > 2 * radius) break;
      if (const Vec3 p = ray.at(t); std::abs(object.distance(p)) <= 1e-9) points.push_back(p);
      t += kSkip;
    }
  }
  return points;
}

}  // namespace scanmill::simulate
