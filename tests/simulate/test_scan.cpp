// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

#include "mesh/limits.hpp"
#include "simulate/demo_plans.hpp"

namespace scanmill::simulate {
namespace {

std::unique_ptr<Object> object_named(std::string_view name) { return std::move(make_object(name)).value(); }

Sensor small_sensor() {
  Sensor sensor;
  sensor.pixels_x = 140;
  sensor.pixels_y = 100;
  return sensor;
}

RangeMap scanned(const Object& object, const Sensor& sensor, const Pose& pose, std::uint64_t seed = 1,
                 int threads = 1) {
  const ChunkLoop loop(threads);
  const CancelFlag cancel;
  return scan(object, sensor, pose, seed, {loop, cancel}).value();
}

bool same_bits(const RangeMap& a, const RangeMap& b) {
  return a.points.size() == b.points.size() &&
         std::memcmp(a.points.data(), b.points.data(), a.points.size() * sizeof(Vec3)) == 0;
}

Vec3 direction_of(const Sensor& sensor, std::size_t pixel) {
  const auto nx = static_cast<std::size_t>(sensor.pixels_x);
  const double column = static_cast<double>(pixel % nx), row = static_cast<double>(pixel / nx);
  return {((column + 0.5) / static_cast<double>(sensor.pixels_x) - 0.5) * sensor.field_x_mm,
          ((row + 0.5) / static_cast<double>(sensor.pixels_y) - 0.5) * sensor.field_y_mm, sensor.stand_off_mm};
}

class DemoSolid : public testing::TestWithParam<std::string> {};

TEST_P(DemoSolid, GivesPointsOnTheSurfaceInTheBandAndInPlainSight) {
  const auto object = object_named(GetParam());
  DemoPlan plan = demo_plan(GetParam());
  const Sensor sensor = plan.sensor = small_sensor();
  std::size_t returns = 0;
  for (std::size_t i = 0; i < plan.poses.size(); i += 3) {
    const Pose& pose = plan.poses[i];
    const RangeMap map = scanned(*object, sensor, pose, view_seed(2, i));
    for (const Vec3& p : map.points) {
      if (!is_finite(p)) {
        ASSERT_TRUE(std::isnan(p.x) && std::isnan(p.y) && std::isnan(p.z));
        continue;
      }
      ++returns;
      const Vec3 global = pose.apply(p), ray = unit(global - pose.translation);
      ASSERT_LE(std::abs(object->surface_distance(global)), 6 * sensor.noise_mm);
      ASSERT_GE(p.z, 135);
      ASSERT_LE(p.z, 165);
      ASSERT_EQ(p.x, static_cast<float>(p.x));
      ASSERT_EQ(p.z, static_cast<float>(p.z));
      // Nothing stands between the sensor and the point; the last stretch is noise.
      for (double before = 6.1 * sensor.noise_mm; before < 60; before += 0.37)
        ASSERT_GE(object->distance(global - ray * before), -1e-6) << "point " << global.x << " " << global.y;
    }
  }
  EXPECT_GT(returns, 10000u);
}

INSTANTIATE_TEST_SUITE_P(Solids, DemoSolid, testing::Values("figurine", "handset"),
                         [](const auto& test) { return test.param; });

TEST(Scan, MeetsTheSphereWhereTheRayDoes) {
  // The sphere's near pole at the stand-off; the limb leaves the band 15 mm further on.
  const auto sphere = object_named("sphere");
  Sensor sensor = small_sensor();
  sensor.noise_mm = 0;
  sensor.max_incidence_deg = 60;
  const double limit = cos_of_degrees(60);
  const Pose pose = pose_looking_at({0, 0, 170}, {0, 0, 0}, {0, 1, 0});
  for (const bool perspective : {true, false}) {
    sensor.perspective = perspective;
    const RangeMap map = scanned(*sphere, sensor, pose);
    ASSERT_EQ(map.points.size(), 14000u);
    std::size_t hits = 0;
    for (std::size_t i = 0; i < map.points.size(); ++i) {
      const Vec3 to_pixel = direction_of(sensor, i), centre{0, 0, 170};
      const Vec3 origin = perspective ? Vec3{} : Vec3{to_pixel.x, to_pixel.y, 0};
      const Vec3 d = perspective ? unit(to_pixel) : Vec3{0, 0, 1};
      const double along = dot(centre - origin, d), square = along * along - norm2(centre - origin) + 400;
      const Vec3 hit = origin + d * (along - std::sqrt(std::max(square, 0.0)));
      const double cosine = square < 0 ? -1 : dot(unit(centre - hit), d);
      if (std::abs(cosine - limit) < 1e-6) continue;
      const bool expected = cosine > limit && hit.z <= 165;
      ASSERT_EQ(is_finite(map.points[i]), expected) << "pixel " << i;
      if (expected) {
        ASSERT_LE(norm(map.points[i] - hit), 2e-5) << "pixel " << i;
      }
      hits += expected;
    }
    EXPECT_GT(hits, 4000u);
  }
}

TEST(Scan, SeesNothingBehindWhatStandsBeforeTheBand) {
  // Along x the torus' near side is at 102 to 118 mm, before the band; it covers the middle of the far side, which is
  // in it.
  const auto torus = object_named("torus");
  const Sensor sensor = small_sensor();
  const Pose pose = pose_looking_at({130, 0, 0}, {0, 0, 0}, {0, 0, 1});
  const RangeMap map = scanned(*torus, sensor, pose);
  for (std::size_t i = 0; i < map.points.size(); ++i)
    if (std::abs(direction_of(sensor, i).x) < 10) {
      EXPECT_FALSE(is_finite(map.points[i])) << "pixel " << i;
    }
  // From farther off the near side itself is measured.
  const RangeMap near = scanned(*torus, sensor, pose_looking_at({170, 0, 0}, {0, 0, 0}, {0, 0, 1}));
  EXPECT_TRUE(is_finite(near.points[50 * 140 + 70]));
  EXPECT_NEAR(near.points[50 * 140 + 70].z, 142, 0.2);
}

TEST(Scan, GivesTheSameBitsForAnyNumberOfThreads) {
  const auto figurine = object_named("figurine");
  const Pose pose = demo_plan("figurine").poses[1];
  const RangeMap one = scanned(*figurine, small_sensor(), pose, 5, 1);
  for (const int threads : {2, 7}) EXPECT_TRUE(same_bits(one, scanned(*figurine, small_sensor(), pose, 5, threads)));
  EXPECT_FALSE(same_bits(one, scanned(*figurine, small_sensor(), pose, 6, 1)));
}

TEST(Scan, HasNoiseOfTheStatedSizeAlongTheRayAndItsOwnInEveryView) {
  const auto cube = object_named("cube");
  const Sensor sensor = small_sensor();
  const Pose pose = pose_looking_at({0.3, -0.2, 165.1}, {0.3, -0.2, 0}, {0, 1, 0});
  const RangeMap a = scanned(*cube, sensor, pose, view_seed(1, 0)), b = scanned(*cube, sensor, pose, view_seed(1, 1));
  double n = 0, sum = 0, squares = 0, products = 0;
  for (std::size_t i = 0; i < a.points.size(); ++i) {
    if (!is_finite(a.points[i]) || !is_finite(b.points[i])) continue;
    const Vec3 d = unit(direction_of(sensor, i));
    ASSERT_LE(norm(cross(a.points[i], d)), 2e-5) << "noise leaves the ray";
    const double truth = 150 / d.z, ea = norm(a.points[i]) - truth, eb = norm(b.points[i]) - truth;
    n += 1;
    sum += ea;
    squares += ea * ea;
    products += ea * eb;
  }
  ASSERT_GT(n, 4000);
  EXPECT_NEAR(sum / n, 0, 0.0015);
  EXPECT_NEAR(std::sqrt(squares / n), 0.025, 0.001);
  EXPECT_NEAR(products / squares, 0, 0.06);
}

TEST(Scan, RefusesASensorOutOfItsLimitsAndStopsWhenTold) {
  const auto cube = object_named("cube");
  const ChunkLoop loop(1);
  CancelFlag cancel;
  Sensor sensor;
  sensor.field_x_mm = 0;
  const auto bad = scan(*cube, sensor, {}, 1, {loop, cancel});
  ASSERT_FALSE(bad.ok());
  EXPECT_EQ(bad.error().code, Code::BadParameter);
  EXPECT_NE(bad.error().message.find("field_x_mm"), std::string::npos) << bad.error().message;
  cancel.set();
  const auto stopped = scan(*cube, small_sensor(), {}, 1, {loop, cancel});
  ASSERT_FALSE(stopped.ok());
  EXPECT_EQ(stopped.error().code, Code::Cancelled);
}

}  // namespace
}  // namespace scanmill::simulate
