// SPDX-License-Identifier: Apache-2.0
#include "support/shapes.hpp"

#include <cmath>
#include <stdexcept>

#include "base/random.hpp"

namespace scanmill::support {
namespace {

constexpr double kPi = 3.14159265358979323846;

/// A fixed turn about a skew axis, so that no face is parallel to the bins.
Vec3 turned(Vec3 p) {
  const double c = 0.8, s = 0.6;
  const Vec3 q{c * p.x - s * p.y, s * p.x + c * p.y, p.z};
  return {q.x, 0.96 * q.y - 0.28 * q.z, 0.28 * q.y + 0.96 * q.z};
}

std::vector<Vec3> torus_points(double ring, double tube, std::size_t count, std::uint64_t seed) {
  std::vector<Vec3> points;
  Random random(seed, 0, 2);
  while (points.size() < count) {
    const double u = 2 * kPi * random.uniform(), v = 2 * kPi * random.uniform();
    if (random.uniform() * (ring + tube) > ring + tube * std::cos(v)) continue;  // uniform by area
    const double r = ring + tube * std::cos(v);
    points.push_back({r * std::cos(u), r * std::sin(u), tube * std::sin(v)});
  }
  return points;
}

/// Over [-x, x] x [-y, y]: height(x, y) where `there` holds.
template <class Height, class There>
std::vector<Vec3> sheet_points(double x, double y, std::size_t count, std::uint64_t seed, Height height, There there) {
  std::vector<Vec3> points;
  Random random(seed, 0, 3);
  for (std::size_t i = 0; i < count; ++i) {
    const double u = random.uniform(-x, x), v = random.uniform(-y, y);
    if (there(u, v)) points.push_back({u, v, height(u, v)});
  }
  return points;
}

std::vector<Vec3> step_points() {
  const double half = 11, height = 5;
  const auto everywhere = [](double, double) { return true; };
  std::vector<Vec3> points = sheet_points(
      half, half, 14000, 41, [&](double x, double) { return x < 0.3 ? 0.37 : height + 0.37; }, everywhere);
  const std::vector<Vec3> wall = sheet_points(
      height / 2, half, 3200, 42, [](double, double) { return 0.0; }, everywhere);
  for (const Vec3 p : wall) points.push_back({0.3, p.y, p.x + height / 2 + 0.37});
  return points;
}

std::vector<Vec3> wavy_points() {
  return sheet_points(
      13, 13, 20000, 51, [](double x, double y) { return 1.5 * std::sin(x / 3.5) * std::cos(y / 4) + 0.2; },
      [](double x, double y) { return x * x + y * y > 25; });
}

std::vector<Vec3> gap_points() {
  return sheet_points(
      13, 10, 16000, 61, [](double x, double y) { return 0.1 * x + 0.05 * y + 0.4; },
      [](double x, double) { return std::abs(x) > 2.6; });
}

std::vector<Vec3> noise_ball() {
  std::vector<Vec3> points;
  Random random(71, 0, 4);
  while (points.size() < 5000) {
    const Vec3 p{random.uniform(-6, 6), random.uniform(-6, 6), random.uniform(-6, 6)};
    if (norm2(p) <= 36) points.push_back(p);
  }
  return points;
}

std::vector<Vec3> turned_all(std::vector<Vec3> points) {
  for (Vec3& p : points) p = turned(p);
  return points;
}

std::vector<Vec3> touching_spheres() {
  std::vector<Vec3> points = sphere_points({-7, 0, 0}, 7, 12000, 81);
  for (const Vec3 p : sphere_points({7, 0, 0}, 7, 12000, 82)) points.push_back(p);
  return points;
}

std::vector<Vec3> duplicates() {
  std::vector<Vec3> points;
  for (const Vec3 p : sphere_points({0.3, 0.2, 0.1}, 9, 12000, 91))
    for (int n = 0; n < 3; ++n) points.push_back(p);
  return points;
}

std::vector<Vec3> grid_plane(double h) {
  std::vector<Vec3> points;
  for (int i = 0; i < 30; ++i)
    for (int j = 0; j < 26; ++j) points.push_back({(i + 0.5) * h, (j + 0.5) * h, 0.5 * h});
  return points;
}

std::vector<Shape> make_shapes() {
  std::vector<Shape> list;
  const auto fixed = [](std::vector<Vec3> (*make)()) { return [make](double) { return make(); }; };
  list.push_back({"sphere",
                  [](double) {
                    return sphere_points({0.2, 0.1, 0.3}, 12, 36000, 11);
                  },
                  true, 2, 0, 1, 4 * kPi * 144, 4 * kPi / 3 * 1728});
  list.push_back({"box",
                  [](double) {
                    return turned_all(box_points({}, {18, 15, 12}, 26000, 21));
                  },
                  true, 2, 0, 1, 2.0 * (18 * 15 + 18 * 12 + 15 * 12), 18.0 * 15 * 12});
  list.push_back({"box on bin planes",
                  [](double h) {
                    return box_points({}, {18 * h, 14 * h, 12 * h}, 26000, 22);
                  },
                  true,
                  2,
                  0,
                  1,
                  {},
                  {}});
  list.push_back({"torus", [](double) { return turned_all(torus_points(10, 4, 34000, 31)); }, true, 0, 0, 1,
                  4 * kPi * kPi * 40, 2 * kPi * kPi * 10 * 16});
  list.push_back({"step", fixed(step_points), false, 1, 1, 1, {}, {}});
  list.push_back({"wavy sheet with a hole", fixed(wavy_points), false, 0, 2, 1, {}, {}});
  list.push_back({"two sheets with a gap", fixed(gap_points), false, 2, 2, 2, {}, {}});
  list.push_back({"thin plate",
                  [](double h) {
                    return turned_all(box_points({}, {18, 16, 2.2 * h}, 24000, 23));
                  },
                  true,
                  2,
                  0,
                  1,
                  {},
                  {},
                  0.1,
                  0.97});  // near the limit of two bins the rim is narrower than the frames

  list.push_back({"touching spheres", fixed(touching_spheres), false, {}, {}, {}, {}, {}});
  list.push_back({"duplicates", fixed(duplicates), true, 2, 0, 1, 4 * kPi * 81, 4 * kPi / 3 * 729});
  list.push_back({"grid plane", grid_plane, false, 1, 1, 1, {}, {}, 0});  // noise moves its points between bins
  list.push_back({"noise ball", fixed(noise_ball), false, {}, {}, {}, {}, {}, -1});
  return list;
}

}  // namespace

Vec3 snapped(Vec3 p) {
  const auto snap = [](double x) { return std::round(x / kGrid) * kGrid + 0.0; };
  return {snap(p.x), snap(p.y), snap(p.z)};
}

std::vector<Vec3> with_noise(std::vector<Vec3> points, double sigma, std::uint64_t seed) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    Random random(seed, i, 5);
    const double x = random.gauss(), y = random.gauss(), z = random.gauss();
    points[i] = snapped(points[i] + Vec3{x, y, z} * sigma);
  }
  return points;
}

std::vector<Vec3> sphere_points(Vec3 centre, double radius, std::size_t count, std::uint64_t seed) {
  std::vector<Vec3> points;
  Random random(seed, 0, 1);
  while (points.size() < count) {
    const Vec3 d{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
    if (const double n2 = norm2(d); n2 <= 1 && n2 > 1e-3) points.push_back(centre + unit(d) * radius);
  }
  return points;
}

std::vector<Vec3> box_points(Vec3 centre, Vec3 size, std::size_t count, std::uint64_t seed) {
  std::vector<Vec3> points;
  Random random(seed, 0, 6);
  const double xy = size.x * size.y, xz = size.x * size.z, yz = size.y * size.z, all = xy + xz + yz;
  for (std::size_t i = 0; i < count; ++i) {
    const double face = random.uniform() * all, side = random.uniform() < 0.5 ? -0.5 : 0.5;
    Vec3 p{random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5)};
    (face < xy ? p.z : face < xy + xz ? p.y : p.x) = side;
    points.push_back(centre + Vec3{p.x * size.x, p.y * size.y, p.z * size.z});
  }
  return points;
}

const std::vector<Shape>& shapes() {
  static const std::vector<Shape> list = make_shapes();
  return list;
}

const Shape& shape_named(const std::string& name) {
  for (const Shape& shape : shapes())
    if (shape.name == name) return shape;
  throw std::runtime_error("no shape named " + name);
}

}  // namespace scanmill::support
