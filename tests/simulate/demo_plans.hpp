// SPDX-License-Identifier: Apache-2.0
// The poses of the demo plans, the archive they make, and how well it covers the solid.
#pragma once
#include <algorithm>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <vector>

#include "base/fields.hpp"
#include "document/document.hpp"
#include "simulate/object.hpp"

namespace scanmill::simulate {

struct DemoPlan {
  Sensor sensor;
  std::vector<Pose> poses;
};

/// jobs/demo/<name>.plan.yaml; throws when the file is not as expected, which fails the test.
inline DemoPlan demo_plan(const std::string& name) {
  const std::string path = std::string(SCANMILL_ROOT) + "/jobs/demo/" + name + ".plan.yaml";
  std::ifstream file(path);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  const auto tree = document::parse_yaml(text, path);
  if (!tree.ok()) throw std::runtime_error(tree.error().text());
  auto vector = [](const document::Node& pose, const char* key) {
    const auto& items = pose.find(key)->items();
    return Vec3{items.at(0).as_number(), items.at(1).as_number(), items.at(2).as_number()};
  };
  DemoPlan plan;
  for (const Field& field : Sensor::fields()) {
    const document::Node& value = *tree->find("sensor")->find(field.name);
    if (const auto* real = std::get_if<double* (*)(void*)>(&field.member)) *(*real)(&plan.sensor) = value.as_number();
    if (const auto* whole = std::get_if<std::int64_t* (*)(void*)>(&field.member))
      *(*whole)(&plan.sensor) = value.as_integer();
    if (const auto* flag = std::get_if<bool* (*)(void*)>(&field.member)) *(*flag)(&plan.sensor) = value.as_bool();
  }
  for (const auto& station : tree->find("stations")->items()) {
    const document::Node& pose = *station.find("pose");
    plan.poses.push_back(pose_looking_at(vector(pose, "eye"), vector(pose, "target"), vector(pose, "up")));
  }
  return plan;
}

/// All measured points of a plan in the global frame.
inline std::vector<Vec3> measured_points(const Object& object, const DemoPlan& plan, const Context& context) {
  std::vector<Vec3> points;
  for (std::size_t i = 0; i < plan.poses.size(); ++i) {
    const auto map = scan(object, plan.sensor, plan.poses[i], view_seed(1, i), context);
    if (!map.ok()) throw std::runtime_error(map.error().text());
    for (const Vec3& p : map->points)
      if (is_finite(p)) points.push_back(plan.poses[i].apply(p));
  }
  return points;
}

/// Distance from each sample to the nearest point, `reach` where none is nearer than that. Points sorted into cubes of
/// edge `reach`.
inline std::vector<double> nearest_distances(const std::vector<Vec3>& samples, const std::vector<Vec3>& points,
                                             const Bounds& bounds, double reach) {
  const Vec3 low = bounds.low - Vec3{2 * reach, 2 * reach, 2 * reach}, size = bounds.high - low;
  auto cell = [&](double v) { return static_cast<std::int64_t>(v / reach); };
  const std::int64_t nx = cell(size.x) + 3, ny = cell(size.y) + 3, nz = cell(size.z) + 3;
  auto index = [&](Vec3 p) {
    return static_cast<std::size_t>((cell(p.z - low.z) * ny + cell(p.y - low.y)) * nx + cell(p.x - low.x));
  };
  std::vector<std::uint32_t> begin(static_cast<std::size_t>(nx * ny * nz) + 1, 0);
  for (const Vec3& p : points) ++begin.at(index(p) + 1);
  for (std::size_t i = 1; i < begin.size(); ++i) begin[i] += begin[i - 1];
  std::vector<Vec3> sorted(points.size());
  for (auto next = begin; const Vec3& p : points) sorted[next[index(p)]++] = p;
  std::vector<double> nearest;
  for (const Vec3& s : samples) {
    double least = reach * reach;
    for (std::int64_t k = -1; k <= 1; ++k)
      for (std::int64_t j = -1; j <= 1; ++j) {
        const std::size_t middle = index(s) + static_cast<std::size_t>((k * ny + j) * nx);
        for (std::size_t i = begin.at(middle - 1); i < begin.at(middle + 2); ++i)
          least = std::min(least, norm2(sorted[i] - s));
      }
    nearest.push_back(std::sqrt(least));
  }
  return nearest;
}

inline std::vector<Vec3> seen_samples(const Object& object, std::size_t count, std::uint64_t seed) {
  std::vector<Vec3> seen;
  for (const Vec3& p : sample_surface(object, count, seed))
    if (object.is_seen(p)) seen.push_back(p);
  return seen;
}

}  // namespace scanmill::simulate
