// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>

#include "base/random.hpp"
#include "front/front.hpp"

namespace scanmill::front {
namespace {

Result<Output> grow(const Input& input) {
  const ChunkLoop loop(1);
  const CancelFlag cancel;
  return grow_fronts(input, {loop, cancel});
}

Output grown(const Input& input) {
  auto out = grow(input);
  EXPECT_TRUE(out.ok()) << out.error().text();
  return out.ok() ? *std::move(out) : Output{};
}

Mesh mesh_of(const Input& input, const Output& out) {
  return {{input.points.begin(), input.points.end()}, out.triangles, out.patch, {}};
}

/// What holds on any input: manifold, one orientation, order, g1, g2, patches numbered as their seeds.
TopologyCounts expect_sound(const Input& input, const Output& out) {
  const TopologyCounts counts = topology_of(mesh_of(input, out));
  EXPECT_EQ(counts.nonmanifold_edges, 0u);
  EXPECT_EQ(counts.nonmanifold_vertices, 0u);
  EXPECT_EQ(counts.misoriented_edges, 0u);
  EXPECT_EQ(out.patch.size(), out.triangles.size());
  EXPECT_TRUE(std::is_sorted(out.triangles.begin(), out.triangles.end()));
  for (const Triangle& t : out.triangles) {
    const Vec3 a = input.points[t[0]], b = input.points[t[1]], c = input.points[t[2]];
    EXPECT_LT(t[0], std::min(t[1], t[2]));
    EXPECT_TRUE(within_range(a, b, c, input.limits.range_bins * input.edge_mm));
    EXPECT_TRUE(angles_at_least(a, b, c, cos_of_degrees(input.limits.min_angle_deg)));
  }
  for (std::uint32_t patch = 0; patch < out.seed_points.size(); ++patch)
    EXPECT_NE(std::count(out.patch.begin(), out.patch.end(), patch), 0) << "patch " << patch << " has no triangles";
  for (const std::uint32_t patch : out.patch) EXPECT_LT(patch, out.seed_points.size());
  return counts;
}

double share_used(const Input& input, const TopologyCounts& counts) {
  return static_cast<double>(counts.vertices_used) / static_cast<double>(input.points.size());
}

/// n x n points at distance 1, moved by up to `jitter` in the plane and across it.
std::vector<Vec3> jittered_grid(std::uint32_t n, double jitter, double height) {
  std::vector<Vec3> points;
  for (std::uint32_t j = 0; j < n; ++j)
    for (std::uint32_t i = 0; i < n; ++i) {
      Random random(7, j * n + i, 1);
      const double dx = random.uniform(-jitter, jitter), dy = random.uniform(-jitter, jitter);
      points.push_back({i + dx, j + dy, random.uniform(-height, height)});
    }
  return points;
}

/// The reduction in miniature: per bin of edge h the sample nearest the centre, none closer than h/2 to an earlier one.
std::vector<Vec3> reduced(const std::vector<Vec3>& samples, double h) {
  std::map<std::array<std::int64_t, 3>, std::pair<double, Vec3>> bins;
  for (const Vec3 p : samples) {
    const Vec3 cell{std::floor(p.x / h), std::floor(p.y / h), std::floor(p.z / h)};
    const double far = norm2(p - (cell + Vec3{0.5, 0.5, 0.5}) * h);
    const std::array<std::int64_t, 3> key{static_cast<std::int64_t>(cell.x), static_cast<std::int64_t>(cell.y),
                                          static_cast<std::int64_t>(cell.z)};
    const auto [place, fresh] = bins.try_emplace(key, far, p);
    if (!fresh && far < place->second.first) place->second = {far, p};
  }
  std::vector<std::pair<double, Vec3>> winners;
  for (const auto& bin : bins) winners.push_back(bin.second);
  std::sort(winners.begin(), winners.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<Vec3> kept;
  for (const auto& [far, p] : winners)
    if (std::none_of(kept.begin(), kept.end(), [&, q = p](Vec3 k) { return norm2(k - q) < h * h / 4; }))
      kept.push_back(p);
  return kept;
}

std::vector<Vec3> sphere(double radius, double h) {
  std::vector<Vec3> samples;
  Random random(11, 0, 2);
  for (int n = 0; n < 60000; ++n) samples.push_back(unit({random.gauss(), random.gauss(), random.gauss()}) * radius);
  return reduced(samples, h);
}

std::vector<Vec3> box(double edge, double h) {
  std::vector<Vec3> samples;
  Random random(13, 0, 3);
  for (int n = 0; n < 60000; ++n) {
    const double u = random.uniform(0, edge), v = random.uniform(0, edge), side = n % 2 ? edge : 0;
    samples.push_back(n % 6 < 2 ? Vec3{u, v, side} : n % 6 < 4 ? Vec3{side, u, v} : Vec3{u, side, v});
  }
  return reduced(samples, h);
}

std::vector<Vec3> noise(std::uint32_t n, double size) {
  std::vector<Vec3> points;
  Random random(17, n, 4);
  for (std::uint32_t i = 0; i < n; ++i) {
    const double x = random.uniform(0, size), y = random.uniform(0, size);
    points.push_back({x, y, random.uniform(0, size)});
  }
  return points;
}

TEST(GrowFronts, CoversAFlatGridWithOnePatch) {
  const auto points = jittered_grid(20, 0.3, 0.05);
  Input input{points, 1, {}, {{9.5, 9.5, 0}}, {}};
  const Output out = grown(input);
  const TopologyCounts counts = expect_sound(input, out);
  EXPECT_EQ(out.seed_points.size(), 1u);
  EXPECT_EQ(counts.components, 1u);
  EXPECT_GE(share_used(input, counts), 0.95);
}

TEST(GrowFronts, UsesASphereWithTenSeeds) {
  const auto points = sphere(20, 2);
  Input input{points, 2, {}, {}, {}};
  for (std::uint64_t n = 0; n < 10; ++n) input.seeds.push_back(points[mix64(n) % points.size()]);
  const Output out = grown(input);
  const TopologyCounts counts = expect_sound(input, out);
  EXPECT_GE(share_used(input, counts), 0.95);
}

TEST(GrowFronts, StopsAtAnEdgeWhenNormalsMustAgree) {
  const auto points = box(20, 1);
  Input input{points, 1, {}, {{10, 10, 20}}, {}};
  input.limits.min_normal_dot = 0.9;
  const Output out = grown(input);
  const TopologyCounts counts = expect_sound(input, out);
  EXPECT_GE(counts.vertices_used, 350u);
  EXPECT_GT(out.refused.normal, 0u);
  for (const Triangle& t : out.triangles)
    for (const std::uint32_t v : t) EXPECT_GT(points[v].z, 20 - 1.5);
}

TEST(GrowFronts, CountsRefusalsByTheLimitThatRefused) {
  const auto points = sphere(12, 1.5);
  Input input{points, 1.5, {}, {points[0]}, {}};
  const Output usual = grown(input);
  input.limits.range_bins = 1.6;
  EXPECT_NE(grown(input).refused.range, usual.refused.range);
  input.limits = {};
  input.limits.min_angle_deg = 25;
  EXPECT_GT(grown(input).refused.angle, usual.refused.angle);
  input.limits = {};
  input.limits.min_normal_dot = 0.98;
  EXPECT_GT(grown(input).refused.normal, usual.refused.normal);
}

TEST(GrowFronts, DoesNotBridgeAGapWiderThanG1) {
  auto points = jittered_grid(12, 0.2, 0);
  for (const Vec3 p : jittered_grid(12, 0.2, 0)) points.push_back(p + Vec3{11 + 2.5 + 0.5, 0, 0});
  Input input{points, 1, {}, {{5.5, 5.5, 0}}, {}};
  for (const Triangle& t : grown(input).triangles) EXPECT_LT(t[2], 144u);
  input.seeds.clear();  // automatic seeds reach the other sheet too
  const Output out = grown(input);
  EXPECT_EQ(expect_sound(input, out).components, 2u);
}

TEST(GrowFronts, TakesItsOrientationFromTheNormals) {
  const auto points = jittered_grid(8, 0.2, 0);
  for (const double sign : {1.0, -1.0}) {
    const std::vector<Vec3> normals(points.size(), Vec3{0, 0, sign});
    const Input input{points, 1, {}, {}, normals};
    for (const Triangle& t : grown(input).triangles)
      EXPECT_GT(sign * cross(points[t[1]] - points[t[0]], points[t[2]] - points[t[0]]).z, 0);
  }
}

TEST(GrowFronts, SewsPatchesOfSeveralSeedsInOneOrientation) {
  const auto points = box(20, 1);
  Input input{points, 1, {}, {}, {}};
  std::vector<Vec3> normals;
  for (const Vec3 p : points) {  // outward, of the face the point lies on
    const Vec3 q = p - Vec3{10, 10, 10};
    const double ax = std::abs(q.x), ay = std::abs(q.y), az = std::abs(q.z);
    normals.push_back(az >= ax && az >= ay ? Vec3{0, 0, q.z > 0 ? 1.0 : -1.0}
                      : ay >= ax           ? Vec3{0, q.y > 0 ? 1.0 : -1.0, 0}
                                           : Vec3{q.x > 0 ? 1.0 : -1.0, 0, 0});
  }
  input.normals = normals;
  input.seeds = {{10, 10, 20}, {10, 10, 0}, {0, 10, 10}, {20, 10, 10}, {10, 0, 10}, {10, 20, 10}};
  input.limits.min_normal_dot = 0.9;
  const Output out = grown(input);
  const TopologyCounts counts = expect_sound(input, out);
  EXPECT_EQ(out.seed_points.size(), 6u);
  EXPECT_GE(share_used(input, counts), 0.95);
  EXPECT_GT(signed_volume(mesh_of(input, out)), 7000);
  EXPECT_EQ(counts.components, 1u);
}

TEST(GrowFronts, GivesTheSameTrianglesEveryTime) {
  const auto points = sphere(10, 1.5);
  const Input input{points, 1.5, {}, {}, {}};
  const Output a = grown(input), b = grown(input);
  EXPECT_EQ(a.triangles, b.triangles);
  EXPECT_EQ(a.patch, b.patch);
}

TEST(GrowFronts, StaysManifoldOnPointsThatAreNoSurface) {
  for (const double size : {4.0, 7.0}) {
    const auto points = noise(200, size);
    for (const double dot : {-1.0, 0.0, 0.9}) {
      Input input{points, 1, {}, {}, {}};
      input.limits.min_normal_dot = dot;
      expect_sound(input, grown(input));
    }
  }
}

TEST(GrowFronts, TakesDegenerateInput) {
  const std::vector<std::vector<Vec3>> clouds{
      {},
      {{1, 2, 3}},
      {{0, 0, 0}, {1, 0, 0}},
      {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}},
      std::vector<Vec3>(50, Vec3{1, 1, 1}),
      {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}, {4, 0, 0}},
      {{0, 0, 0}, {0, 0, 0}, {1, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 1, 0}},
      {{1e15, 0, 0}, {0, 1e15, 0}, {0, 0, -1e15}, {0, 0, 0}},
  };
  const std::vector<std::size_t> expected{0, 0, 0, 1, 0, 0, 1, 0};
  for (std::size_t i = 0; i < clouds.size(); ++i) {
    for (const double min_angle : {5.0, 0.0}) {
      Input input{clouds[i], 1, {}, {}, {}};
      input.limits.min_angle_deg = min_angle;
      const Output out = grown(input);
      expect_sound(input, out);
      EXPECT_EQ(out.triangles.size(), expected[i]) << "cloud " << i;
    }
  }
}

TEST(GrowFronts, RefusesWhatItCannotDoAndSaysWhatCan) {
  const std::vector<Vec3> many(kMaxPoints + 1);
  const auto out = grow({many, 1, {}, {}, {}});
  ASSERT_FALSE(out.ok());
  EXPECT_EQ(out.error().code, Code::Unsupported);
  EXPECT_NE(out.error().message.find("50,001"), std::string::npos) << out.error().message;
  EXPECT_NE(out.error().message.find("stars"), std::string::npos);
  const std::vector<Vec3> wrong{{0, 0, 0}, {0, std::nan(""), 0}};
  EXPECT_FALSE(grow({wrong, 1, {}, {}, {}}).ok());
  EXPECT_FALSE(grow({{}, 0, {}, {}, {}}).ok());
}

TEST(GrowFronts, StopsWhenCancelled) {
  const auto points = jittered_grid(20, 0.3, 0);
  const ChunkLoop loop(1);
  CancelFlag cancel;
  cancel.set();
  const auto out = grow_fronts({points, 1, {}, {}, {}}, {loop, cancel});
  ASSERT_FALSE(out.ok());
  EXPECT_EQ(out.error().code, Code::Cancelled);
}

}  // namespace
}  // namespace scanmill::front
