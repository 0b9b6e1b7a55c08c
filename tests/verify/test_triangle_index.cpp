// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "verify/meshes.hpp"
#include "verify/triangle_index.hpp"

namespace scanmill::verify {
namespace {

/// Distance of a point to a closed triangle in long double, from a parametrisation that shares nothing with src/.
long double distance_by_sides_and_plane(Vec3 p, Vec3 a, Vec3 b, Vec3 c) {
  using Real = long double;
  struct V {
    Real x, y, z;
  };
  auto from = [](Vec3 u, Vec3 v) { return V{Real(u.x) - Real(v.x), Real(u.y) - Real(v.y), Real(u.z) - Real(v.z)}; };
  auto in = [](V u, V v) { return u.x * v.x + u.y * v.y + u.z * v.z; };
  auto times = [](V u, V v) { return V{u.y * v.z - u.z * v.y, u.z * v.x - u.x * v.z, u.x * v.y - u.y * v.x}; };
  auto to_side = [&](Vec3 s, Vec3 e) {
    const V d = from(e, s), w = from(p, s);
    const Real length2 = in(d, d);
    Real t = length2 > 0 ? in(w, d) / length2 : 0;
    t = std::clamp(t, Real(0), Real(1));
    const V r{w.x - t * d.x, w.y - t * d.y, w.z - t * d.z};
    return std::sqrt(in(r, r));
  };
  Real best = std::min({to_side(a, b), to_side(b, c), to_side(c, a)});
  const V n = times(from(b, a), from(c, a));
  const Real n2 = in(n, n);
  if (n2 > 0 && in(times(n, from(b, a)), from(p, a)) > 0 && in(times(n, from(c, b)), from(p, b)) > 0 &&
      in(times(n, from(a, c)), from(p, c)) > 0)
    best = std::min(best, std::abs(in(n, from(p, a))) / std::sqrt(n2));
  return best;
}

Hit by_force(const Mesh& mesh, Vec3 p) {
  Hit best{1e300, 0, Feature::Face};
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& [a, b, c] = mesh.triangles[t];
    if (cross(mesh.positions[b] - mesh.positions[a], mesh.positions[c] - mesh.positions[a]) == Vec3{}) continue;
    const Closest found = closest_on_triangle(p, mesh.positions[a], mesh.positions[b], mesh.positions[c]);
    if (found.distance2 < best.distance2) best = {found.distance2, t, found.feature};
  }
  return best;
}

void expect_same(const Hit& found, const Hit& wanted, std::size_t n, Vec3 p) {
  ASSERT_TRUE(found.triangle == wanted.triangle && found.distance2 == wanted.distance2 &&
              found.feature == wanted.feature)
      << "point " << n << " at " << p.x << " " << p.y << " " << p.z << ": triangle " << found.triangle << " at "
      << std::sqrt(found.distance2) << ", by force " << wanted.triangle << " at " << std::sqrt(wanted.distance2);
}

/// Points on, beside and far from the mesh; on its vertices and middles of its sides; in runs and alone.
std::vector<Vec3> questions(const Mesh& mesh, std::uint64_t seed) {
  Random random(seed, 1, 2);
  std::vector<Vec3> points;
  for (int n = 0; n < 300; ++n) {
    const Triangle& t = mesh.triangles[random.next() % mesh.triangles.size()];
    const Vec3 a = mesh.positions[t[0]], b = mesh.positions[t[1]], c = mesh.positions[t[2]];
    const double u = random.uniform(), v = random.uniform() * (1 - u);
    const double off = n % 3 == 0 ? 0 : n % 3 == 1 ? 1e-3 : 1;
    const Vec3 p = a + (b - a) * u + (c - a) * v + Vec3{random.gauss(), random.gauss(), random.gauss()} * off;
    points.push_back(p);
    for (int k = 1; k < n % 12; ++k) points.push_back(p + Vec3{k * 0.01, 0, 0});
    if (n % 4 == 0) points.insert(points.end(), {a, (b + c) * 0.5, c});
    if (n % 50 == 0) points.push_back(p * 1e4);
  }
  return points;
}

TEST(TriangleIndex, AnswersAsMeasuringEveryTriangle) {
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    const Mesh mesh = soup(static_cast<std::size_t>(seed < 4 ? seed : seed * seed * 7), seed);
    const TriangleIndex index(mesh);
    if (index.empty()) continue;
    TriangleIndex::Search search(index);
    const auto points = questions(mesh, seed);
    std::vector<Hit> hits(points.size());
    search.nearest(points, hits);
    for (std::size_t n = 0; n < points.size(); ++n)
      ASSERT_NO_FATAL_FAILURE(expect_same(hits[n], by_force(mesh, points[n]), n, points[n])) << "seed " << seed;
  }
}

TEST(TriangleIndex, BreaksTiesByNumberOnASheet) {
  const Mesh mesh = flat_sheet(20, 0.5);
  const TriangleIndex index(mesh);
  TriangleIndex::Search search(index);
  std::vector<Vec3> points;
  for (int i = 0; i <= 40; ++i)
    for (int j = 0; j <= 40; ++j) points.push_back({i * 0.25, j * 0.25, (i + j) % 2 * 0.125});
  std::vector<Hit> hits(points.size());
  search.nearest(points, hits);
  for (std::size_t n = 0; n < points.size(); ++n)
    ASSERT_NO_FATAL_FAILURE(expect_same(hits[n], by_force(mesh, points[n]), n, points[n]));
}

TEST(TriangleIndex, AnswersFarFromTheOriginToo) {
  Mesh mesh = sheet(30, 0.4, [](double x, double y) { return 0.1 * x * y; });
  for (Vec3& p : mesh.positions) p = as_float(p + Vec3{20000, -70000, 5000});
  const TriangleIndex index(mesh);
  TriangleIndex::Search search(index);
  const auto points = questions(mesh, 3);
  for (std::size_t n = 0; n < points.size(); ++n)
    ASSERT_NO_FATAL_FAILURE(expect_same(search.nearest(points[n]), by_force(mesh, points[n]), n, points[n]));
}

TEST(TriangleIndex, DoesNotDependOnWhatWasAskedBefore) {
  const Mesh mesh = sheet(40, 0.3, [](double x, double y) { return 0.05 * x * x - 0.2 * y; });
  const TriangleIndex index(mesh);
  auto points = questions(mesh, 9);
  std::vector<Hit> hits(points.size()), back(points.size());
  TriangleIndex::Search(index).nearest(points, hits);
  std::reverse(points.begin(), points.end());
  TriangleIndex::Search(index).nearest(points, back);
  std::reverse(points.begin(), points.end());
  std::reverse(back.begin(), back.end());
  for (std::size_t n = 0; n < points.size(); ++n) ASSERT_NO_FATAL_FAILURE(expect_same(back[n], hits[n], n, points[n]));
}

TEST(TriangleIndex, TakesSizesFromDustToWorlds) {
  for (const double scale : {1e-12, 1e-3, 1e6, 1e15, 1e30}) {
    Mesh mesh = soup(60, 5);
    for (Vec3& p : mesh.positions) p = as_float(p * scale);
    const TriangleIndex index(mesh);
    TriangleIndex::Search search(index);
    for (std::size_t n = 0; n < mesh.positions.size(); ++n) {
      const Vec3 p = mesh.positions[n] * 1.01;
      ASSERT_NO_FATAL_FAILURE(expect_same(search.nearest(p), by_force(mesh, p), n, p)) << scale;
    }
  }
}

TEST(ClosestOnTriangle, MeasuresTheDistance) {
  Random random(4, 4, 4);
  for (int n = 0; n < 20000; ++n) {
    Vec3 at[3];
    for (Vec3& v : at) v = as_float({random.gauss(), random.gauss(), random.gauss()});
    if (n % 5 == 0) at[2] = as_float(at[0] + (at[1] - at[0]) * random.uniform());  // nearly on the side
    if (n % 31 == 0) at[1] = at[0];
    if (n % 97 == 0) at[2] = at[1] = at[0];
    const Vec3 p{random.gauss(), random.gauss(), random.gauss()};
    const double wanted = static_cast<double>(distance_by_sides_and_plane(p, at[0], at[1], at[2]));
    ASSERT_NEAR(std::sqrt(closest_on_triangle(p, at[0], at[1], at[2]).distance2), wanted, 1e-12 + 1e-9 * wanted) << n;
  }
}

TEST(ClosestOnTriangle, NamesTheFeature) {
  const Vec3 a{0, 0, 0}, b{2, 0, 0}, c{0, 2, 0};
  const std::pair<Vec3, Feature> cases[] = {
      {{0.5, 0.5, 3}, Feature::Face}, {{1, -1, 1}, Feature::EdgeAB},   {{2, 2, 0}, Feature::EdgeBC},
      {{-1, 1, 0}, Feature::EdgeCA},  {{-1, -1, 0}, Feature::CornerA}, {{5, -1, 0}, Feature::CornerB},
      {{-1, 5, 1}, Feature::CornerC},
  };
  for (const auto& [p, feature] : cases) EXPECT_EQ(closest_on_triangle(p, a, b, c).feature, feature);
}

}  // namespace
}  // namespace scanmill::verify
