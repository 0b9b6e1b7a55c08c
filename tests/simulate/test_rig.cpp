// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cstring>

#include "base/random.hpp"
#include "mesh/limits.hpp"
#include "simulate/rig.hpp"

namespace scanmill::simulate {
namespace {

/// A sphere of triangles by rings; vertices on the sphere.
Mesh sphere_mesh(double radius, std::uint32_t rings) {
  Mesh mesh;
  const std::uint32_t around = 2 * rings;
  mesh.positions.push_back({0, 0, radius});
  for (std::uint32_t i = 1; i < rings; ++i)
    for (std::uint32_t j = 0; j < around; ++j) {
      const double tilt = 180.0 * i / rings, turn = 360.0 * j / around;
      const double s = cos_of_degrees(90 - tilt) * radius;
      mesh.positions.push_back(
          {s * cos_of_degrees(turn), s * cos_of_degrees(90 - turn), cos_of_degrees(tilt) * radius});
    }
  mesh.positions.push_back({0, 0, -radius});
  const auto last = static_cast<std::uint32_t>(mesh.positions.size() - 1);
  auto at = [&](std::uint32_t i, std::uint32_t j) { return 1 + (i - 1) * around + j % around; };
  for (std::uint32_t j = 0; j < around; ++j) {
    mesh.triangles.push_back({0, at(1, j), at(1, j + 1)});
    for (std::uint32_t i = 1; i + 1 < rings; ++i) {
      mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i, j + 1)});
      mesh.triangles.push_back({at(i, j + 1), at(i + 1, j), at(i + 1, j + 1)});
    }
    mesh.triangles.push_back({at(rings - 1, j), last, at(rings - 1, j + 1)});
  }
  return mesh;
}

Sensor small_sensor() {
  Sensor sensor;
  sensor.pixels_x = 140;
  sensor.pixels_y = 100;
  return sensor;
}

const Pose kAbove = pose_looking_at({0, 0, 165}, {0, 0, 0}, {0, 1, 0});

RigView viewed(const Scene& scene, const Sensor& sensor, const Effects& effects, const Pose& pose = kAbove,
               std::uint64_t seed = 1, int threads = 1) {
  const ChunkLoop loop(threads);
  const CancelFlag cancel;
  return take_view(scene, sensor, effects, pose, seed, {loop, cancel}).value();
}

std::uint64_t finite_points(const RangeMap& map) {
  std::uint64_t count = 0;
  for (const Vec3& p : map.points) count += is_finite(p);
  return count;
}

TEST(RayTree, MeetsWhatALookAtEveryTriangleMeets) {
  // Soup of triangles of all sizes, some far off and some without area; rays from everywhere, some along axes.
  Random random(7, 0, 0);
  Mesh mesh;
  auto point = [&](double size) {
    return Vec3{random.uniform(-size, size), random.uniform(-size, size), random.uniform(-size, size)};
  };
  for (std::uint32_t t = 0; t < 600; ++t) {
    const Vec3 at = point(30);
    const double size = t % 10 == 0 ? 20 : 2;
    for (int k = 0; k < 3; ++k) mesh.positions.push_back(t % 50 == 7 ? at : at + point(size));
    mesh.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
  }
  const RayTree tree(mesh);
  int met = 0;
  for (int r = 0; r < 3000; ++r) {
    Ray ray{point(80), unit(point(1))};
    if (r % 3 == 0) ray.direction = unit(point(10) - ray.origin);
    if (r % 7 == 0) ray.direction = r % 2 == 0 ? Vec3{0, 0, -1} : Vec3{0, 1, 0};
    const Interval range{0, r % 5 == 0 ? 60.0 : 1e300};
    double least = 1e300;
    std::uint32_t best = kNoTriangle;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
      const Vec3 a = mesh.positions[3 * t] - ray.origin, b = mesh.positions[3 * t + 1] - ray.origin,
                 c = mesh.positions[3 * t + 2] - ray.origin;
      const Vec3 n = cross(b - a, c - a);
      const double steep = dot(n, ray.direction);
      if (steep == 0) continue;
      const double at = dot(n, a) / steep;
      const Vec3 p = ray.direction * at;
      const double u = dot(cross(b - a, p - a), n), v = dot(cross(c - b, p - b), n), w = dot(cross(a - c, p - c), n);
      if (u < 0 || v < 0 || w < 0 || at < range.low || at > range.high || at >= least) continue;
      least = at;
      best = t;
    }
    const RayTree::Hit hit = tree.first(ray, range);
    ASSERT_EQ(hit.triangle, best) << "ray " << r;
    if (best != kNoTriangle) {
      ASSERT_NEAR(hit.t, least, 1e-9);
      ++met;
    }
  }
  EXPECT_GT(met, 500);
}

TEST(RayTree, LetsNoRaySlipBetweenTriangles) {
  const Mesh mesh = sphere_mesh(20, 24);
  const RayTree tree(mesh);
  // Straight at every vertex and at the middle of every edge, from outside and along the axes.
  for (const Triangle& triangle : mesh.triangles)
    for (int k = 0; k < 3; ++k) {
      const Vec3 a = mesh.positions[triangle[static_cast<std::size_t>(k)]],
                 b = mesh.positions[triangle[static_cast<std::size_t>((k + 1) % 3)]];
      for (const Vec3 p : {a, (a + b) * 0.5}) {
        const Vec3 from = p * 4;
        ASSERT_NE(tree.first({from, unit(-p)}, {0, 1e300}).triangle, kNoTriangle);
      }
    }
}

TEST(RayTree, HoldsNothingOfAnEmptyMeshAndAllOfOneTriangle) {
  EXPECT_EQ(RayTree(Mesh{}).first({{0, 0, 9}, {0, 0, -1}}, {0, 100}).triangle, kNoTriangle);
  Mesh one;
  one.positions = {{-1, -1, 0}, {1, -1, 0}, {0, 1, 0}};
  one.triangles = {{0, 1, 2}};
  one.offset = {100, 0, 0};
  const RayTree tree(one);
  EXPECT_EQ(tree.first({{100, 0, 9}, {0, 0, -1}}, {0, 100}).triangle, 0u);
  EXPECT_EQ(tree.first({{0, 0, 9}, {0, 0, -1}}, {0, 100}).triangle, kNoTriangle);
  EXPECT_EQ(tree.first({{100, 0, 9}, {0, 0, -1}}, {0, 8.9}).triangle, kNoTriangle);
}

TEST(Rig, SeesAMeshOfASphereLikeTheSphere) {
  const auto sphere = std::move(make_object("sphere")).value();
  const RayTree tree(sphere_mesh(20, 180));
  Scene solid, mesh;
  solid.add(*sphere);
  mesh.add(tree);
  Sensor sensor = small_sensor();
  sensor.noise_mm = 0;
  const RigView a = viewed(solid, sensor, {}), b = viewed(mesh, sensor, {});
  std::size_t both = 0, one = 0;
  for (std::size_t i = 0; i < a.map.points.size(); ++i) {
    const bool in_a = is_finite(a.map.points[i]), in_b = is_finite(b.map.points[i]);
    both += in_a && in_b;
    one += in_a != in_b;
    // The chords of a degree lie at most 20 (1 - cos(0.5 deg)) = 0.8 um ... twice that inside.
    if (in_a && in_b) {
      ASSERT_LE(norm(a.map.points[i] - b.map.points[i]), 0.02);
    }
  }
  EXPECT_GT(both, 5000u);
  EXPECT_LT(one, 80u);  // at the limit of incidence and of the band
}

TEST(Rig, GivesTheSameBitsForAnyNumberOfThreads) {
  const RayTree tree(sphere_mesh(20, 40));
  Scene scene;
  scene.add(tree);
  scene.add(Block{pose_shifted({0, 0, -30}), {{-40, -40, 0}, {40, 40, 20}}});
  Effects effects;
  effects.noise_by_incidence = 1;
  effects.dropout_from_deg = 50;
  effects.outlier_share = 0.02;
  effects.missing_patches = 3;
  effects.projector_mm = 60;
  effects.station_mm = 0.1;
  effects.station_deg = 0.05;
  const RigView one = viewed(scene, small_sensor(), effects);
  EXPECT_GT(one.counts.outliers, 0u);
  EXPECT_GT(one.counts.dropped, 0u);
  EXPECT_GT(one.counts.missing, 0u);
  EXPECT_GT(one.counts.unlit, 0u);
  EXPECT_EQ(one.counts.returns, finite_points(one.map));
  for (const int threads : {2, 7}) {
    const RigView other = viewed(scene, small_sensor(), effects, kAbove, 1, threads);
    EXPECT_EQ(0, std::memcmp(one.map.points.data(), other.map.points.data(), one.map.points.size() * sizeof(Vec3)));
    EXPECT_EQ(one.pose, other.pose);
  }
}

TEST(Rig, LosesReturnsGraduallyTowardsGrazingIncidence) {
  // A plate turned by 60 degrees: all of it at incidence 60 under parallel rays, where cos is 0.5.
  Scene scene;
  scene.add(Block{pose_turned({1, 0, 0}, 60), {{-100, -100, -1}, {100, 100, 0}}});
  Sensor sensor = small_sensor();
  sensor.perspective = false;
  sensor.field_x_mm = sensor.field_y_mm = 10;
  sensor.max_incidence_deg = 90;
  Effects effects;
  effects.dropout_from_deg = 0;  // lost: (1 - cos) / 1 = half
  const RigView view = viewed(scene, sensor, effects, pose_looking_at({0, 0, 150}, {0, 0, 0}, {0, 1, 0}));
  EXPECT_NEAR(static_cast<double>(view.counts.dropped) / 14000, 0.5, 0.02);
  EXPECT_NEAR(static_cast<double>(view.counts.returns) / 14000, 0.5, 0.02);
}

TEST(Rig, NoiseGrowsWithIncidenceAndOutliersKeepToTheirRay) {
  Scene scene;
  scene.add(Block{pose_turned({1, 0, 0}, 60), {{-100, -100, -1}, {100, 100, 0}}});
  Sensor sensor = small_sensor();
  sensor.perspective = false;
  sensor.field_x_mm = sensor.field_y_mm = 10;
  const Pose pose = pose_looking_at({0, 0, 150}, {0, 0, 0}, {0, 1, 0});
  Sensor exact = sensor;
  exact.noise_mm = 0;
  const RangeMap truth = viewed(scene, exact, {}, pose).map;
  Effects effects;
  effects.noise_by_incidence = 1;  // 1 + (1 / 0.5 - 1) = twice the noise
  const RangeMap noisy = viewed(scene, sensor, effects, pose).map;
  double squares = 0;
  for (std::size_t i = 0; i < truth.points.size(); ++i) {
    const double off = noisy.points[i].z - truth.points[i].z;
    squares += off * off;
  }
  EXPECT_NEAR(std::sqrt(squares / static_cast<double>(truth.points.size())), 0.05, 0.002);
  effects.outlier_share = 0.1;
  effects.outlier_mm = 3;
  const RigView stray = viewed(scene, exact, effects, pose);
  std::uint64_t off = 0;
  for (std::size_t i = 0; i < truth.points.size(); ++i) {
    const Vec3 gap = stray.map.points[i] - truth.points[i];
    ASSERT_LE(std::abs(gap.z), 3.00002);
    ASSERT_EQ(gap.x, 0);
    off += gap.z != 0;
  }
  EXPECT_NEAR(static_cast<double>(off) / 14000, 0.1, 0.01);
  EXPECT_EQ(off, stray.counts.outliers);
}

TEST(Rig, TheProjectorLeavesAShadowBehindAStep) {
  // A block 10 mm high on a plate; light from +60 mm shades the plate at the block's -x side: behind its edge at
  // x = -5, height 10, light at (60, 0, 150): to x = -5 - 65 * 10 / 140 = -9.64.
  Scene scene;
  scene.add(Block{Pose{}, {{-100, -100, -1}, {100, 100, 0}}});
  scene.add(Block{Pose{}, {{-5, -100, 0}, {5, 100, 10}}});
  Sensor sensor = small_sensor();
  sensor.perspective = false;
  sensor.noise_mm = 0;
  Effects effects;
  effects.projector_mm = 60;
  const Pose pose{{1, 0, 0, 0, -1, 0, 0, 0, -1}, {0, 0, 150}};  // +x of the camera is +x
  const RigView view = viewed(scene, sensor, effects, pose);
  for (std::size_t i = 0; i < view.map.points.size(); ++i) {
    const double x = ((static_cast<double>(i % 140) + 0.5) / 140 - 0.5) * 50;
    if (std::abs(x + 5) < 0.2 || std::abs(x + 9.64) < 0.2 || std::abs(x - 5) < 0.2) continue;
    ASSERT_EQ(is_finite(view.map.points[i]), !(x < -5 && x > -9.64)) << x;
  }
}

TEST(Rig, BodiesHideEachOtherAndAreCountedApart) {
  const auto sphere = std::move(make_object("sphere")).value();
  Scene scene;
  scene.add(*sphere);
  scene.add(Block{pose_shifted({0, 0, 21}), {{-3, -3, 0}, {3, 3, 4}}});
  Sensor sensor = small_sensor();
  sensor.noise_mm = 0;
  const RigView view = viewed(scene, sensor, {}, pose_looking_at({0, 0, 170}, {0, 0, 0}, {0, 1, 0}));
  EXPECT_NEAR(view.map.points[50 * 140 + 70].z, 170 - 25, 1e-4);
  EXPECT_GT(view.counts.around, 100u);
  EXPECT_LT(view.counts.around, view.counts.returns / 2);
}

TEST(Rig, StationsStandExactlyAsFarOffAsStated) {
  Effects effects;
  effects.station_mm = 0.1;
  effects.station_deg = 0.05;
  Vec3 mean;
  for (std::uint64_t s = 0; s < 200; ++s) {
    const PoseGap gap = gap_between(displaced(kAbove, effects, view_seed(3, s)), kAbove);
    ASSERT_NEAR(gap.mm, 0.1, 1e-9);
    ASSERT_NEAR(gap.degrees, 0.05, 1e-9);
    mean += displaced(kAbove, effects, view_seed(3, s)).translation - kAbove.translation;
  }
  EXPECT_LT(norm(mean) / 200, 0.02);
  EXPECT_EQ(displaced(kAbove, {}, 1), kAbove);
}

TEST(Rig, RefusesEffectsOutOfTheirLimits) {
  const Scene scene;
  Effects effects;
  effects.outlier_share = 2;
  const ChunkLoop loop(1);
  const CancelFlag cancel;
  const auto view = take_view(scene, small_sensor(), effects, kAbove, 1, {loop, cancel});
  ASSERT_FALSE(view.ok());
  EXPECT_EQ(view.error().code, Code::BadParameter);
  EXPECT_NE(view.error().text().find("outlier_share"), std::string::npos);
}

}  // namespace
}  // namespace scanmill::simulate
