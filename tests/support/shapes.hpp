// SPDX-License-Identifier: Apache-2.0
// Seeded clouds of known shapes. Every coordinate is a multiple of 2^-12 mm and below 2048 mm, so float32 holds it
// exactly and the checker can work in integers.
#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "geom/vec3.hpp"

namespace scanmill::support {

inline constexpr double kGrid = 0x1p-12;  // mm
Vec3 snapped(Vec3 p);

/// What is known of a shape's surface; empty: nothing is promised.
struct Shape {
  std::string name;
  std::function<std::vector<Vec3>(double h)> points;  // without noise; h only where the shape is made of bins
  bool closed = false;
  std::optional<std::int64_t> euler;
  std::optional<std::size_t> loops;
  std::optional<std::size_t> components;
  std::optional<double> area, volume;  // mm2, mm3
  double greatest_noise = 0.1;         // of the bin edge: up to here the above holds
  double least_used = 0.995;           // share of the kept points, up to there
};

/// sphere, box (turned), box on bin planes, torus, step, wavy sheet with a hole, two sheets with a gap, thin plate, two
/// touching spheres, sphere of duplicates, exact grid plane, noise ball.
const std::vector<Shape>& shapes();
const Shape& shape_named(const std::string& name);

/// The points with independent noise of `sigma` mm on each axis, snapped.
std::vector<Vec3> with_noise(std::vector<Vec3> points, double sigma, std::uint64_t seed);

std::vector<Vec3> sphere_points(Vec3 centre, double radius, std::size_t count, std::uint64_t seed);
/// The six faces of an axis-parallel box, uniform by area.
std::vector<Vec3> box_points(Vec3 centre, Vec3 size, std::size_t count, std::uint64_t seed);

}  // namespace scanmill::support
