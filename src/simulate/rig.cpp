// SPDX-License-Identifier: Apache-2.0
#include "simulate/rig.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "base/random.hpp"
#include "mesh/limits.hpp"
#include "simulate/pixels.hpp"

namespace scanmill::simulate {
namespace {

constexpr std::uint64_t kNoisePurpose = 0x6e6f697365;      // "noise"
constexpr std::uint64_t kGrazingPurpose = 0x6772617a65;    // "graze"
constexpr std::uint64_t kOutlierPurpose = 0x73747261790a;  // "stray"
constexpr std::uint64_t kHolePurpose = 0x686f6c65;         // "hole"
constexpr std::uint64_t kStationPurpose = 0x7374617469;    // "stati"
constexpr double kShadow = 1e-4;  // mm; a surface does not shade itself within this of the point it was met at

Vec3 random_direction(Random& random) {
  for (;;) {
    const Vec3 d{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
    if (const double n = norm2(d); n <= 1 && n > 1e-4) return unit(d);
  }
}

struct Hole {
  double x, y;
};

/// All that one pixel needs, the same for all of them.
struct Rig {
  const Scene& scene;
  const Sensor& sensor;
  const Effects& effects;
  const Pose& pose;
  std::uint64_t seed;
  double min_cosine, grazing_cosine;
  std::vector<Hole> holes;

  bool in_band(double z) const {
    return z >= sensor.stand_off_mm - sensor.depth_mm && z <= sensor.stand_off_mm + sensor.depth_mm;
  }
  bool in_hole(const Ray& view) const {
    if (holes.empty()) return false;
    const Vec3 at = view.at(sensor.perspective ? sensor.stand_off_mm / view.direction.z : 0);
    const double reach = effects.missing_radius_mm * effects.missing_radius_mm;
    return std::any_of(holes.begin(), holes.end(), [&](const Hole& hole) {
      const double x = at.x - hole.x, y = at.y - hole.y;
      return x * x + y * y <= reach;
    });
  }
  bool is_lit(Vec3 surface) const {
    if (effects.projector_mm == 0) return true;
    const Vec3 way = surface - pose.apply({effects.projector_mm, 0, 0});
    const double length = norm(way);
    const Ray light{surface - way, way * (1 / length)};
    return scene.first(light, {0, length - kShadow}).body < 0;
  }

  Vec3 measure(std::int64_t column, std::int64_t row, RigCounts& counts) const {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    constexpr Vec3 nothing{nan, nan, nan};
    const Ray view = ray_of_pixel(sensor, column, row);
    const Ray ray{pose.apply(view.origin), pose.turn(view.direction)};
    // What stands before the band hides what is in it, so the ray starts at the sensor, but it ends with the band.
    const Sight sight = scene.first(ray, {0, (sensor.stand_off_mm + sensor.depth_mm) / view.direction.z});
    if (sight.body < 0 || !in_band(view.at(sight.t).z)) return nothing;
    const double cosine = -dot(sight.normal, ray.direction);
    if (cosine < min_cosine) return nothing;
    const auto pixel = static_cast<std::uint64_t>(row * sensor.pixels_x + column);
    if (cosine < grazing_cosine) {
      const double lost = (grazing_cosine - cosine) / (grazing_cosine - min_cosine);
      if (Random(seed, pixel, kGrazingPurpose).uniform() < lost) {
        ++counts.dropped;
        return nothing;
      }
    }
    if (in_hole(view)) {
      ++counts.missing;
      return nothing;
    }
    if (!is_lit(ray.at(sight.t))) {
      ++counts.unlit;
      return nothing;
    }
    Random random(seed, pixel, kNoisePurpose);
    double noise = sensor.noise_mm * random.gauss();
    if (effects.noise_by_incidence > 0) noise *= 1 + effects.noise_by_incidence * (1 / cosine - 1);
    bool is_outlier = false;
    if (effects.outlier_share > 0) {
      Random stray(seed, pixel, kOutlierPurpose);
      is_outlier = stray.uniform() < effects.outlier_share;
      if (is_outlier) noise += stray.uniform(-effects.outlier_mm, effects.outlier_mm);
    }
    const Vec3 p = view.at(sight.t + noise);
    const Vec3 written{static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)};
    if (!in_band(written.z)) return nothing;
    ++counts.returns;
    counts.outliers += is_outlier;
    counts.around += sight.body > 0;
    return written;
  }
};

}  // namespace

std::span<const Field> Effects::fields() {
  using E = Effects;
  static const Field table[] = {
      field<E, &E::noise_by_incidence>("noise_by_incidence", "", "Noise grows by this times (1 / cos(incidence) - 1).",
                                       {0, 100}),
      field<E, &E::dropout_from_deg>(
          "dropout_from_deg", "",
          "From this incidence to the sensor's max_incidence_deg the share of lost returns grows from none to all.",
          {0, 90}),
      field<E, &E::outlier_share>("outlier_share", "", "Share of the returns that lie elsewhere on their ray.",
                                  {0, 0.9}),
      field<E, &E::outlier_mm>("outlier_mm", "", "Outliers lie uniformly up to so far before or behind.", {0, 1000}),
      field<E, &E::missing_patches>("missing_patches", "", "Round holes in every view where nothing came back.",
                                    {0, 1000}),
      field<E, &E::missing_radius_mm>("missing_radius_mm", "", "Radius of the holes at the stand-off.", {0, 1000}),
      field<E, &E::projector_mm>("projector_mm", "",
                                 "The light comes from so far along +x of the camera; what it does not reach is not "
                                 "seen; 0: nothing is shaded.",
                                 {-1000, 1000}),
      field<E, &E::station_mm>("station_mm", "", "Every view is taken so far off its station, in a drawn direction.",
                               {0, 100}),
      field<E, &E::station_deg>("station_deg", "", "Every view is turned so much, about a drawn axis.", {0, 45}),
  };
  return table;
}

std::uint64_t view_seed(std::uint64_t seed, std::uint64_t station) { return mix64(seed ^ mix64(station)); }

Pose displaced(const Pose& pose, const Effects& effects, std::uint64_t seed) {
  if (effects.station_mm == 0 && effects.station_deg == 0) return pose;
  Random random(seed, 0, kStationPurpose);
  const Vec3 shift = random_direction(random) * effects.station_mm;
  Pose off = pose_turned(random_direction(random), effects.station_deg);
  off.translation = shift;
  return pose.after(off);
}

Result<RigView> take_view(const Scene& scene, const Sensor& sensor, const Effects& effects, const Pose& pose,
                          std::uint64_t seed, const Context& context) {
  if (const auto problems = problems_of(Sensor::fields(), &sensor); !problems.empty())
    return fail(Code::BadParameter, problems.front(), "sensor");
  if (const auto problems = problems_of(Effects::fields(), &effects); !problems.empty())
    return fail(Code::BadParameter, problems.front(), "effects");
  RigView out;
  out.pose = displaced(pose, effects, seed);
  const double min_cosine = cos_of_degrees(sensor.max_incidence_deg);
  const double grazing =
      effects.dropout_from_deg >= sensor.max_incidence_deg ? min_cosine : cos_of_degrees(effects.dropout_from_deg);
  Rig rig{scene, sensor, effects, out.pose, seed, min_cosine, grazing, {}};
  Random holes(seed, 0, kHolePurpose);
  for (std::int64_t i = 0; i < effects.missing_patches; ++i) {
    const double x = holes.uniform(-0.5, 0.5) * sensor.field_x_mm, y = holes.uniform(-0.5, 0.5) * sensor.field_y_mm;
    rig.holes.push_back({x, y});
  }
  const auto width = static_cast<std::size_t>(sensor.pixels_x), height = static_cast<std::size_t>(sensor.pixels_y);
  out.map.pixels_x = sensor.pixels_x;
  out.map.pixels_y = sensor.pixels_y;
  out.map.points.resize(width * height);
  std::vector<RigCounts> counts(height);
  for_each_range(context, height, 4, [&](std::size_t begin, std::size_t end) {
    for (std::size_t row = begin; row < end; ++row)
      for (std::size_t column = 0; column < width; ++column)
        out.map.points[row * width + column] =
            rig.measure(static_cast<std::int64_t>(column), static_cast<std::int64_t>(row), counts[row]);
  });
  if (context.cancel.is_set()) return fail(Code::Cancelled, "stopped while scanning");
  for (const RigCounts& row : counts) {
    out.counts.returns += row.returns;
    out.counts.outliers += row.outliers;
    out.counts.dropped += row.dropped;
    out.counts.missing += row.missing;
    out.counts.unlit += row.unlit;
    out.counts.around += row.around;
  }
  return out;
}

Result<RangeMap> scan(const Object& object, const Sensor& sensor, const Pose& pose, std::uint64_t seed,
                      const Context& context) {
  Scene scene;
  scene.add(object);
  TRY_ASSIGN(RigView view, take_view(scene, sensor, {}, pose, seed, context));
  return std::move(view.map);
}

}  // namespace scanmill::simulate
