// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "base/random.hpp"
#include "geom/angles.hpp"
#include "simulate/fringes.hpp"

namespace scanmill::fringe {
namespace {

using simulate::Block;
using simulate::FringeRig;
using simulate::Scene;

struct Threads {
  explicit Threads(int count) : loop(count) {}
  ChunkLoop loop;
  CancelFlag cancel;
  Context context{loop, cancel};
};
const Pose kAbove{{1, 0, 0, 0, -1, 0, 0, 0, -1}, {0, 0, 150}};  // looks down; z = 0 is the plate

std::vector<Shifted> gratings_of(const FringeRig& rig, std::vector<Picture> object, const std::vector<Picture>& plate) {
  std::vector<Shifted> gratings;
  for (std::size_t g = 0; g < rig.periods_mm.size(); ++g) {
    Shifted& grating = gratings.emplace_back();
    grating.period_mm = rig.periods_mm[g];
    for (std::size_t k = 0; k < static_cast<std::size_t>(rig.steps); ++k) {
      grating.object.push_back(object[g * static_cast<std::size_t>(rig.steps) + k]);
      grating.plate.push_back(plate[g * static_cast<std::size_t>(rig.steps) + k]);
    }
  }
  return gratings;
}

RangeMap decoded(const Scene& scene, const Sensor& sensor, const FringeRig& rig, int threads = 1) {
  const Threads own(threads);
  auto object = simulate::take_fringes(scene, sensor, rig, kAbove, 1, own.context).value();
  const auto plate = simulate::take_plate(sensor, rig, 2, own.context).value();
  return range_map(simulate::optics_of(sensor, rig), gratings_of(rig, std::move(object), plate),
                   rig.bits == 16 ? 65535 : 255, {})
      .value();
}

Sensor half_sensor() {
  Sensor sensor;
  sensor.pixels_x = 350;  // 7 pixels a millimetre, 3.5 a fringe
  sensor.pixels_y = 100;
  return sensor;
}

struct Errors {
  double rms = 0, worst = 0;
  std::size_t points = 0;
};
/// Height of the points over the true surface, along z.
template <class Surface>
Errors errors_of(const RangeMap& map, const Surface& surface) {
  Errors errors;
  for (const Vec3& p : map.points) {
    if (!is_finite(p)) continue;
    const double off = surface(kAbove.apply(p));
    errors.rms += off * off;
    errors.worst = std::max(errors.worst, std::abs(off));
    ++errors.points;
  }
  errors.rms = std::sqrt(errors.rms / static_cast<double>(errors.points));
  return errors;
}

TEST(WaveOf, TellsPhaseMeanAndModulationForAnyNumberOfSteps) {
  for (const std::size_t steps : {3u, 4u, 5u, 8u})
    for (double turns = -0.49; turns < 0.5; turns += 0.07) {
      std::vector<double> samples;
      for (std::size_t k = 0; k < steps; ++k) {
        const double whole = 1 + turns + static_cast<double>(k) / static_cast<double>(steps);
        samples.push_back(100 + 40 * sine_cosine_of(360 * whole).cosine);
      }
      const Wave wave = wave_of(samples);
      EXPECT_NEAR(wave.turns, turns, 1e-12);
      EXPECT_NEAR(wave.mean, 100, 1e-10);
      EXPECT_NEAR(wave.modulation, 40, 1e-10);
    }
}

TEST(Optics, DepthAndLineAreEachOthersInverse) {
  const Optics optics;
  for (const double z : {135.0, 149.0, 150.0, 165.0})
    for (const Vec3 pixel : {Vec3{0, 0, 150}, Vec3{20, -9, 150}}) {
      const Vec3 p = pixel * (z / 150);
      EXPECT_NEAR(optics.depth_of(optics.line_through(p) - pixel.x), z, 1e-10);
    }
}

/// Steps of 0.5, 1.3, 4 and 9 mm on a plate: far more than a fringe, which is 1.25 mm.
void add_stairs(Scene& scene) {
  const double heights[] = {-6, 0.5, 1.8, 5.8, -2};
  for (int i = 0; i < 5; ++i) scene.add(Block{Pose{}, {{-25.0 + 10 * i, -30, -20}, {-15.0 + 10 * i, 30, heights[i]}}});
}
double above_stairs(Vec3 p) {
  const double heights[] = {-6, 0.5, 1.8, 5.8, -2};
  double least = 1e300;
  for (int i = 0; i < 5; ++i) {
    const double x = -25.0 + 10 * i, beside = std::max({x - p.x, p.x - x - 10, 0.0});
    if (beside < 0.05 && std::abs(p.z - heights[i]) < std::abs(least)) least = p.z - heights[i];
  }
  return least;
}

TEST(RangeMap, OfStairsIsRightTo25MicrometresAtTwoLinePairsPerMillimetre) {
  Scene scene;
  add_stairs(scene);
  const RangeMap map = decoded(scene, half_sensor(), {});
  const Errors errors = errors_of(map, above_stairs);
  EXPECT_GT(errors.points, 25000u);  // of 35,000; the rest lies in shadow
  EXPECT_LE(errors.rms, 0.025);
  EXPECT_LE(errors.worst, 0.2);
  EXPECT_GT(map.count(Flaw::Dark) + map.count(Flaw::Shadow), 1000u);
  EXPECT_EQ(map.regions, 0u);
  std::printf("stairs: rms %.4f mm, worst %.4f mm, %zu points\n", errors.rms, errors.worst, errors.points);
}

TEST(RangeMap, OfABallIsRightTo25Micrometres) {
  const auto ball = std::move(simulate::make_object("sphere")).value();
  Scene scene;
  scene.add(*ball);
  Sensor sensor = half_sensor();
  sensor.pixels_y = 350;
  const Threads one(1);
  const Pose pose{{1, 0, 0, 0, -1, 0, 0, 0, -1}, {0, 0, 162}};
  FringeRig rig;
  auto object = simulate::take_fringes(scene, sensor, rig, pose, 1, one.context).value();
  const auto plate = simulate::take_plate(sensor, rig, 2, one.context).value();
  const RangeMap map =
      range_map(simulate::optics_of(sensor, rig), gratings_of(rig, std::move(object), plate), 255, {}).value();
  double squares = 0, count = 0;
  for (const Vec3& p : map.points) {
    if (!is_finite(p)) continue;
    const Vec3 at = pose.apply(p), ray = unit(at - pose.translation);
    // Along the ray, as range errors are.
    const double along = -dot(pose.translation, ray);
    const double t = along - std::sqrt(std::max(along * along - norm2(pose.translation) + 400, 0.0));
    const double off = norm(at - pose.translation) - t;
    squares += off * off;
    count += 1;
  }
  EXPECT_GT(count, 25000);
  EXPECT_LE(std::sqrt(squares / count), 0.025);
  std::printf("ball: rms %.4f mm, %.0f points\n", std::sqrt(squares / count), count);
}

TEST(RangeMap, OfOneGratingFollowsASmoothSurface) {
  // A ramp over the whole field, nine fringes high; neighbours lead from end to end.
  Scene scene;
  Pose turned = pose_turned({0, 1, 0}, 15);
  scene.add(Block{turned, {{-60, -60, -5}, {60, 60, 0}}});
  FringeRig rig;
  rig.periods_mm = {0.5};
  const RangeMap map = decoded(scene, half_sensor(), rig);
  const Vec3 normal = turned.turn({0, 0, 1});
  const Errors errors = errors_of(map, [&](Vec3 p) { return dot(p, normal) / normal.z; });
  EXPECT_EQ(map.regions, 1u);
  EXPECT_GT(errors.points, 33000u);
  EXPECT_LE(errors.rms, 0.025);
}

TEST(RangeMap, IsTheSameForAnyNumberOfThreads) {
  Scene scene;
  add_stairs(scene);
  const RangeMap one = decoded(scene, half_sensor(), {}, 1);
  for (const int threads : {2, 7}) {
    const RangeMap other = decoded(scene, half_sensor(), {}, threads);
    EXPECT_EQ(0, std::memcmp(one.points.data(), other.points.data(), one.points.size() * sizeof(Vec3)));
  }
}

TEST(RangeMap, MasksSaturatedPixels) {
  Scene scene;
  add_stairs(scene);
  Sensor sensor = half_sensor();
  const FringeRig rig;
  const Threads one(1);
  auto object = simulate::take_fringes(scene, sensor, rig, kAbove, 1, one.context).value();
  for (std::size_t i = 0; i < 350; ++i) object[2].pixels[50 * 350 + i] = 255;
  const auto plate = simulate::take_plate(sensor, rig, 2, one.context).value();
  const RangeMap map =
      range_map(simulate::optics_of(sensor, rig), gratings_of(rig, std::move(object), plate), 255, {}).value();
  EXPECT_EQ(map.count(Flaw::Saturated), 350u);
  for (std::size_t i = 0; i < 350; ++i) EXPECT_FALSE(is_finite(map.points[50 * 350 + i]));
}

TEST(RangeMap, NamesWhatIsWrongWithPictures) {
  const Optics optics;
  const Picture picture{4, 3, std::vector<std::uint16_t>(12, 9)}, other{3, 4, picture.pixels};
  auto message = [&](std::vector<Shifted> gratings) { return range_map(optics, gratings, 255, {}).error().message; };
  EXPECT_NE(message({}).find("no grating"), std::string::npos);
  EXPECT_NE(message({{0.5, {picture, picture}, {picture, picture}}}).find("at least 3"), std::string::npos);
  EXPECT_NE(message({{0.5, {picture, picture, other}, {picture, picture, picture}}}).find("3 x 4 pixels, wanted 4 x 3"),
            std::string::npos);
  const std::vector<Picture> three(3, picture);
  EXPECT_NE(message({{4, three, three}, {0.5, three, three}}).find("needs at least 13.3"), std::string::npos);
  EXPECT_NE(message({{0.5, three, three}, {16, three, three}}).find("coarsest first"), std::string::npos);
}

}  // namespace
}  // namespace scanmill::fringe
