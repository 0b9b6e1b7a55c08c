// SPDX-License-Identifier: Apache-2.0
#include "simulate/fringes.hpp"

#include <algorithm>
#include <cmath>

#include "base/random.hpp"
#include "geom/angles.hpp"
#include "simulate/pixels.hpp"

namespace scanmill::simulate {
namespace {

constexpr std::uint64_t kGreyPurpose = 0x67726579;  // "grey"
constexpr double kBright = 0.42;                    // of white: mean brightness under upright light
constexpr double kDark = 0.01;                      // of white: stray light everywhere
constexpr double kShadow = 1e-4;                    // mm

Result<void> check(const Sensor& sensor, const FringeRig& rig) {
  if (const auto problems = problems_of(Sensor::fields(), &sensor); !problems.empty())
    return fail(Code::BadParameter, problems.front(), "sensor");
  if (!sensor.perspective)
    return fail(Code::BadParameter, "a fringe camera is a pinhole; this sensor's rays are parallel", "sensor");
  if (rig.steps < 3 || rig.steps > 64 || (rig.bits != 8 && rig.bits != 16) || rig.baseline_mm == 0 ||
      rig.periods_mm.empty())
    return fail(Code::BadParameter, "fringes want 3 to 64 steps, 8 or 16 bits, a baseline and at least one period");
  for (std::size_t g = 0; g < rig.periods_mm.size(); ++g)
    if (!(rig.periods_mm[g] > 0) || (g > 0 && rig.periods_mm[g] >= rig.periods_mm[g - 1]))
      return fail(Code::BadParameter, "fringe periods want to be above 0, the coarsest first");
  return {};
}

class Camera {
 public:
  Camera(const Sensor& sensor, const FringeRig& rig, std::uint64_t seed)
      : sensor_(sensor),
        rig_(rig),
        optics_(optics_of(sensor, rig)),
        seed_(seed),
        white_(rig.bits == 16 ? 65535 : 255) {}

  /// All pictures of one pixel that sees `p` (sensor frame) under light of cosine `lit`; 0: none.
  void expose(std::int64_t column, std::int64_t row, Vec3 p, double lit, std::vector<fringe::Picture>& out) const {
    const auto pixel = static_cast<std::size_t>(row * sensor_.pixels_x + column);
    Random random(seed_, pixel, kGreyPurpose);
    const double behind = std::abs(p.z - sensor_.stand_off_mm) - sensor_.depth_mm;
    const double fade = std::clamp(1 - behind / (0.1 * sensor_.depth_mm), 0.0, 1.0);
    const double mean = kBright * lit;
    std::size_t picture = 0;
    for (const double period : rig_.periods_mm) {
      const double turns = lit > 0 ? optics_.line_through(p) / period : 0;
      for (std::int64_t k = 0; k < rig_.steps; ++k, ++picture) {
        const double shift = static_cast<double>(k) / static_cast<double>(rig_.steps);
        const double whole = turns + shift, part = whole - std::floor(whole);
        const double wave = sine_cosine_of(360 * part).cosine;
        const double grey =
            kDark + mean * (1 + rig_.visibility * fade * wave) + rig_.noise_levels / 255 * random.gauss();
        const double value = std::floor(grey * white_ + 0.5);
        out[picture].pixels[pixel] = static_cast<std::uint16_t>(std::clamp(value, 0.0, white_));
      }
    }
  }

  std::vector<fringe::Picture> blank() const {
    fringe::Picture one{sensor_.pixels_x, sensor_.pixels_y, {}};
    one.pixels.assign(static_cast<std::size_t>(sensor_.pixels_x * sensor_.pixels_y), 0);
    return std::vector<fringe::Picture>(rig_.periods_mm.size() * static_cast<std::size_t>(rig_.steps), one);
  }

 private:
  const Sensor& sensor_;
  const FringeRig& rig_;
  fringe::Optics optics_;
  std::uint64_t seed_;
  double white_;
};

}  // namespace

fringe::Optics optics_of(const Sensor& sensor, const FringeRig& rig) {
  return {sensor.field_x_mm, sensor.field_y_mm, sensor.stand_off_mm, sensor.depth_mm, rig.baseline_mm};
}

Result<std::vector<fringe::Picture>> take_fringes(const Scene& scene, const Sensor& sensor, const FringeRig& rig,
                                                  const Pose& pose, std::uint64_t seed, const Context& context) {
  TRY(check(sensor, rig));
  const Camera camera(sensor, rig, seed);
  std::vector<fringe::Picture> pictures = camera.blank();
  const Vec3 projector = pose.apply({rig.baseline_mm, 0, 0});
  for_each_range(context, static_cast<std::size_t>(sensor.pixels_y), 4, [&](std::size_t begin, std::size_t end) {
    for (auto row = static_cast<std::int64_t>(begin); row < static_cast<std::int64_t>(end); ++row)
      for (std::int64_t column = 0; column < sensor.pixels_x; ++column) {
        const Ray view = ray_of_pixel(sensor, column, row);
        const Ray ray{pose.apply(view.origin), pose.turn(view.direction)};
        const Sight sight = scene.first(ray, {0, 4 * sensor.stand_off_mm});
        Vec3 p{0, 0, sensor.stand_off_mm};
        double lit = 0;
        if (sight.body >= 0) {
          const Vec3 way = ray.at(sight.t) - projector;
          const double length = norm(way);
          const Ray light{projector, way * (1 / length)};
          p = view.at(sight.t);
          if (dot(sight.normal, light.direction) < 0 && scene.first(light, {0, length - kShadow}).body < 0)
            lit = -dot(sight.normal, light.direction);
        }
        camera.expose(column, row, p, lit, pictures);
      }
  });
  if (context.cancel.is_set()) return fail(Code::Cancelled, "stopped while taking pictures");
  return pictures;
}

Result<std::vector<fringe::Picture>> take_plate(const Sensor& sensor, const FringeRig& rig, std::uint64_t seed,
                                                const Context& context) {
  // Behind its front face at the stand-off nothing matters; it reaches beyond the field.
  const double reach = 2 * (sensor.field_x_mm + sensor.field_y_mm);
  Scene scene;
  scene.add(Block{Pose{}, {{-reach, -reach, sensor.stand_off_mm}, {reach, reach, sensor.stand_off_mm + 10}}});
  return take_fringes(scene, sensor, rig, Pose{}, seed, context);
}

}  // namespace scanmill::simulate
