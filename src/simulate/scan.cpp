// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <limits>

#include "base/random.hpp"
#include "mesh/limits.hpp"
#include "simulate/trace.hpp"

namespace scanmill::simulate {
namespace {

constexpr std::uint64_t kNoisePurpose = 0x6e6f697365;  // "noise"

/// All that one pixel needs, the same for all of them.
struct Scanner {
  const Object& object;
  const Sensor& sensor;
  const Pose& pose;
  std::uint64_t seed;
  Bounds box;
  double min_cosine;

  Ray ray_in_view(std::int64_t column, std::int64_t row) const {
    const double nx = static_cast<double>(sensor.pixels_x), ny = static_cast<double>(sensor.pixels_y);
    const double x = ((static_cast<double>(column) + 0.5) / nx - 0.5) * sensor.field_x_mm;
    const double y = ((static_cast<double>(row) + 0.5) / ny - 0.5) * sensor.field_y_mm;
    if (!sensor.perspective) return {{x, y, 0}, {0, 0, 1}};
    return {{0, 0, 0}, unit({x, y, sensor.stand_off_mm})};
  }

  bool in_band(double z) const {
    return z >= sensor.stand_off_mm - sensor.depth_mm && z <= sensor.stand_off_mm + sensor.depth_mm;
  }

  Vec3 measure(std::int64_t column, std::int64_t row) const {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    constexpr Vec3 nothing{nan, nan, nan};
    const Ray view = ray_in_view(column, row);
    const Ray ray{pose.apply(view.origin), pose.turn(view.direction)};
    Interval range = clip(ray, box);
    // What stands before the band hides what is in it, so tracing starts at the object, but it ends with the band.
    range.low = std::max(range.low, 0.0);
    range.high = std::min(range.high, (sensor.stand_off_mm + sensor.depth_mm) / view.direction.z);
    if (range.low > range.high) return nothing;
    const double t = first_crossing(object, ray, range, 1);
    if (t > range.high || !in_band(view.at(t).z)) return nothing;
    if (-dot(normal_at(object, ray.at(t)), ray.direction) < min_cosine) return nothing;
    Random random(seed, static_cast<std::uint64_t>(row * sensor.pixels_x + column), kNoisePurpose);
    const Vec3 p = view.at(t + sensor.noise_mm * random.gauss());
    const Vec3 written{static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)};
    return in_band(written.z) ? written : nothing;
  }
};

}  // namespace

std::uint64_t view_seed(std::uint64_t seed, std::uint64_t station) { return mix64(seed ^ mix64(station)); }

Result<RangeMap> scan(const Object& object, const Sensor& sensor, const Pose& pose, std::uint64_t seed,
                      const Context& context) {
  if (const auto problems = problems_of(Sensor::fields(), &sensor); !problems.empty())
    return fail(Code::BadParameter, problems.front(), "sensor");
  // A hair around the box keeps rays that run along one of its faces.
  Bounds box = object.bounds();
  box.low = box.low - Vec3{0.01, 0.01, 0.01};
  box.high = box.high + Vec3{0.01, 0.01, 0.01};
  const Scanner scanner{object, sensor, pose, seed, box, cos_of_degrees(sensor.max_incidence_deg)};
  RangeMap map;
  map.pixels_x = sensor.pixels_x;
  map.pixels_y = sensor.pixels_y;
  map.points.resize(static_cast<std::size_t>(sensor.pixels_x * sensor.pixels_y));
  for_each_range(context, static_cast<std::size_t>(sensor.pixels_y), 4, [&](std::size_t begin, std::size_t end) {
    for (std::size_t row = begin; row < end; ++row)
      for (std::int64_t column = 0; column < sensor.pixels_x; ++column)
        map.points[row * static_cast<std::size_t>(sensor.pixels_x) + static_cast<std::size_t>(column)] =
            scanner.measure(column, static_cast<std::int64_t>(row));
  });
  if (context.cancel.is_set()) return fail(Code::Cancelled, "stopped while scanning");
  return map;
}

}  // namespace scanmill::simulate
