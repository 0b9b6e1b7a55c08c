// SPDX-License-Identifier: Apache-2.0
// Surfaces fitted to shapes that are known.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "surfaces/surfaces.hpp"

namespace scanmill::surfaces {
namespace {

struct Workers {
  explicit Workers(int threads = 1) : loop(threads) {}
  ChunkLoop loop;
  CancelFlag cancel;
  Context context() const { return {loop, cancel}; }
};

/// A grid of nu x nv cells, place(i, j) at its corners; outward is the side of u x v.
Mesh grid(int nu, int nv, const std::function<Vec3(int, int)>& place, bool round = false) {
  Mesh mesh;
  const int across = round ? nu : nu + 1;
  for (int j = 0; j <= nv; ++j)
    for (int i = 0; i < across; ++i) mesh.positions.push_back(place(i, j));
  auto at = [&](int i, int j) { return static_cast<std::uint32_t>(j * across + i % across); };
  auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    while (a > b || a > c) std::swap(a, b), std::swap(b, c);
    mesh.triangles.push_back({a, b, c});
  };
  for (int j = 0; j < nv; ++j)
    for (int i = 0; i < nu; ++i) {
      add(at(i, j), at(i + 1, j), at(i + 1, j + 1));
      add(at(i, j), at(i + 1, j + 1), at(i, j + 1));
    }
  std::sort(mesh.triangles.begin(), mesh.triangles.end());
  return mesh;
}

FittedSurfaces fitted(const Mesh& mesh, Samples samples, double tolerance = 0.25, int threads = 1) {
  const Workers workers(threads);
  auto found = fit_surfaces(mesh, std::move(samples), {tolerance}, 1, workers.context());
  EXPECT_TRUE(found.ok()) << (found.ok() ? "" : found.error().text());
  return found.ok() ? std::move(found).value() : FittedSurfaces{};
}

/// The surface at (u, v), by the poles alone.
Vec3 at(const SplineSurface& surface, Uv p) {
  const CubicBasis u = surface.u.basis(p.u), v = surface.v.basis(p.v);
  Vec3 sum;
  for (std::size_t j = 0; j < 4; ++j)
    for (std::size_t i = 0; i < 4; ++i)
      sum += surface.poles[(v.first + j) * surface.u.poles() + u.first + i] * (u.value[i] * v.value[j]);
  return sum;
}

/// Greatest distance of the border polylines' corners from their own surface.
double border_off(const FittedSurfaces& surfaces) {
  double worst = 0;
  for (const FittedChart& chart : surfaces.charts)
    for (const TrimLoop& loop : chart.loops)
      for (std::size_t k = 0; k < loop.places.size(); ++k)
        worst = std::max(worst, norm(at(chart.surface, loop.parameters[k]) - loop.places[k]));
  return worst;
}

Mesh tilted_plane(int cells = 20) {
  const Vec3 u = unit({1, 0.3, 0.2}), v = unit(cross({0.1, -0.4, 1}, u));
  return grid(cells, cells, [&](int i, int j) { return Vec3{5, 6, 7} + u * i + v * j; });
}

/// A cube of 12 mm, its faces grids of 1 mm, edges exact.
Mesh cube() {
  constexpr int n = 12;
  Mesh mesh;
  std::vector<std::array<int, 3>> keys;
  auto row = [&](std::array<int, 3> key) {
    const auto found = std::find(keys.begin(), keys.end(), key);
    if (found != keys.end()) return static_cast<std::uint32_t>(found - keys.begin());
    keys.push_back(key);
    mesh.positions.push_back({double(key[0]), double(key[1]), double(key[2])});
    return static_cast<std::uint32_t>(keys.size() - 1);
  };
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (const int side : {0, n})
      for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
          auto corner = [&](int a, int b) {
            std::array<int, 3> key{};
            key[axis] = side;
            key[(axis + 1) % 3] = a;
            key[(axis + 2) % 3] = b;
            return row(key);
          };
          std::uint32_t a = corner(i, j), b = corner(i + 1, j), c = corner(i + 1, j + 1), d = corner(i, j + 1);
          if (side == 0) std::swap(b, d);
          mesh.triangles.push_back({a, b, c});
          mesh.triangles.push_back({a, c, d});
        }
  return mesh;
}

TEST(FitSurfaces, MakesOneSurfaceWithFourCornersOfAPlane) {
  const Mesh mesh = tilted_plane();
  const FittedSurfaces surfaces = fitted(mesh, samples_of(mesh));
  ASSERT_EQ(surfaces.charts.size(), 1u);
  EXPECT_TRUE(surfaces.facets.empty());
  EXPECT_NEAR(surfaces.fitted_area_mm2, 400, 1e-9);
  const FittedChart& chart = surfaces.charts[0];
  EXPECT_LT(chart.max_mm, surfaces.quantum_mm);
  ASSERT_EQ(chart.loops.size(), 1u);
  EXPECT_EQ(chart.loops[0].places.size(), 4u) << "straight borders need their ends only";
  EXPECT_LE(border_off(surfaces), 2 * surfaces.quantum_mm) << "poles and places are multiples of the quantum";
  EXPECT_DOUBLE_EQ(surfaces.quantum_mm, 1e-3);
  EXPECT_EQ(chart.triangles.size(), mesh.triangles.size());
}

TEST(FitSurfaces, FollowsACylinderAllTheWayRound) {
  constexpr int around = 60;
  constexpr double radius = 10;
  const Mesh mesh = grid(
      around, 20,
      [&](int i, int j) {
        const double turn = 2 * M_PI * (i + 0.5 * (j % 2)) / around;
        return Vec3{radius * std::cos(turn), radius * std::sin(turn), double(j)};
      },
      true);
  const FittedSurfaces surfaces = fitted(mesh, samples_of(mesh));
  EXPECT_GE(surfaces.charts.size(), 3u);
  EXPECT_LE(surfaces.charts.size(), 8u);
  EXPECT_TRUE(surfaces.facets.empty());
  EXPECT_LT(surfaces.max_mm, 0.1);
  EXPECT_LT(surfaces.gap_mm, 0.1);
  // Inside every trimmed surface: the poles of its middle stand for places at the radius.
  for (const FittedChart& chart : surfaces.charts) {
    Uv middle;
    for (const Uv& p : chart.loops[0].parameters) middle.u += p.u, middle.v += p.v;
    const double share = 1 / static_cast<double>(chart.loops[0].parameters.size());
    const Vec3 p = at(chart.surface, {middle.u * share, middle.v * share});
    EXPECT_NEAR(std::sqrt(p.x * p.x + p.y * p.y), radius, 0.1);
  }
}

TEST(FitSurfaces, MeetsInTheEdgesOfACube) {
  const Mesh mesh = cube();
  const FittedSurfaces surfaces = fitted(mesh, samples_of(mesh));
  ASSERT_EQ(surfaces.charts.size(), 6u);
  EXPECT_TRUE(surfaces.facets.empty());
  EXPECT_LT(surfaces.max_mm, 0.02);
  EXPECT_LT(surfaces.gap_mm, 0.02);
  for (const FittedChart& chart : surfaces.charts) {
    EXPECT_EQ(chart.loops[0].places.size(), 4u);
    EXPECT_EQ(chart.surface.poles.size(), 16u) << "a plane needs one span";
  }
}

TEST(FitSurfaces, FindsTheEdgeThatTheMeshCutsOff) {
  // Two planes at right angles; the mesh goes across the edge in chords, the samples do not.
  const Mesh mesh = grid(21, 16, [](int i, int j) {
    const double s = i - 10.5;  // no column on the edge
    return s < 0 ? Vec3{s, double(j), 0} : Vec3{0, double(j), -s};
  });
  Samples samples = samples_of(mesh);
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const Triangle& c = mesh.triangles[t];
    const Vec3 middle = (mesh.positions[c[0]] + mesh.positions[c[1]] + mesh.positions[c[2]]) * (1.0 / 3);
    if (middle.x * middle.z == 0) continue;
    for (const Vec3 p : {Vec3{-0.1, middle.y, 0}, Vec3{0, middle.y, -0.1}, Vec3{-0.3, middle.y, 0}}) {
      samples.places.push_back(p);
      samples.triangle.push_back(t);
    }
  }
  const FittedSurfaces surfaces = fitted(mesh, std::move(samples));
  ASSERT_EQ(surfaces.charts.size(), 2u);
  EXPECT_TRUE(surfaces.facets.empty());
  EXPECT_LT(surfaces.max_mm, 0.02) << "the chord is 0.35 mm off";
  EXPECT_LT(surfaces.gap_mm, 0.02);
}

TEST(FitSurfaces, LeavesFacetsWhereTheToleranceDoesNotHold) {
  const Mesh mesh = tilted_plane();
  Samples samples = samples_of(mesh);
  const std::uint32_t far = 2 * (20 * 9 + 9);
  const Triangle& c = mesh.triangles[far];
  const Vec3 n = unit(cross(mesh.positions[c[1]] - mesh.positions[c[0]], mesh.positions[c[2]] - mesh.positions[c[0]]));
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)  // a crowd keeps the surface where it is
    for (int k = 0; k < 10; ++k) {
      const Triangle& x = mesh.triangles[t];
      samples.places.push_back((mesh.positions[x[0]] + mesh.positions[x[1]] + mesh.positions[x[2]]) * (1.0 / 3));
      samples.triangle.push_back(t);
    }
  samples.places.push_back(mesh.positions[c[0]] + n * 0.9);
  samples.triangle.push_back(far);
  const FittedSurfaces surfaces = fitted(mesh, samples);
  ASSERT_EQ(surfaces.charts.size(), 1u);
  EXPECT_EQ(surfaces.facets, (std::vector<std::uint32_t>{far}));
  EXPECT_EQ(surfaces.corners.size(), 1u);
  EXPECT_EQ(surfaces.charts[0].loops.size(), 2u) << "the facet leaves a hole";
  EXPECT_NEAR(surfaces.fitted_area_mm2, 399.5, 1e-9);
  EXPECT_NEAR(surfaces.area_mm2, 400, 1e-9);
  EXPECT_LE(surfaces.max_mm, 0.25);
  EXPECT_TRUE(fitted(mesh, samples, 1).facets.empty()) << "a wider tolerance takes it";
}

TEST(FitSurfaces, GivesTheSameBytesForAnyThreads) {
  constexpr int around = 48;
  const Mesh mesh = grid(
      around, 30,
      [&](int i, int j) {
        const double turn = 2 * M_PI * i / around, r = 8 + 2 * std::sin(0.3 * j) + std::cos(3 * turn);
        return Vec3{r * std::cos(turn), r * std::sin(turn), double(j)};
      },
      true);
  const FittedSurfaces one = fitted(mesh, samples_of(mesh), 0.25, 1);
  EXPECT_GT(one.charts.size(), 3u);
  for (const int threads : {2, 7}) {
    const FittedSurfaces other = fitted(mesh, samples_of(mesh), 0.25, threads);
    ASSERT_EQ(other.charts.size(), one.charts.size());
    EXPECT_EQ(other.facets, one.facets);
    EXPECT_EQ(other.gap_mm, one.gap_mm);
    EXPECT_EQ(other.rms_mm, one.rms_mm);
    for (std::size_t c = 0; c < one.charts.size(); ++c) {
      EXPECT_EQ(other.charts[c].surface.poles, one.charts[c].surface.poles);
      EXPECT_EQ(other.charts[c].triangles, one.charts[c].triangles);
      ASSERT_EQ(other.charts[c].loops.size(), one.charts[c].loops.size());
      for (std::size_t l = 0; l < one.charts[c].loops.size(); ++l)
        EXPECT_EQ(other.charts[c].loops[l].places, one.charts[c].loops[l].places);
    }
  }
}

TEST(FitSurfaces, TakesEveryTriangleOnceWhateverTheMesh) {
  Mesh mesh = tilted_plane(8);
  // Three triangles on an edge, one without area, one apart.
  const auto apex = static_cast<std::uint32_t>(mesh.positions.size());
  mesh.positions.push_back(mesh.positions[40] + Vec3{0, 0, 5});
  mesh.triangles.push_back({mesh.triangles[30][0], mesh.triangles[30][1], apex});
  mesh.triangles.push_back({3, 3, 4});
  for (const Vec3 p : {Vec3{90, 0, 0}, Vec3{91, 0, 0}, Vec3{90, 1, 0}}) mesh.positions.push_back(p);
  mesh.triangles.push_back({apex + 1, apex + 2, apex + 3});
  const FittedSurfaces surfaces = fitted(mesh, samples_of(mesh));
  std::vector<int> seen(mesh.triangles.size(), 0);
  for (const FittedChart& chart : surfaces.charts)
    for (const std::uint32_t t : chart.triangles) ++seen[t];
  for (const std::uint32_t t : surfaces.facets) ++seen[t];
  for (std::size_t t = 0; t < seen.size(); ++t)
    EXPECT_EQ(seen[t], mesh.triangles[t][0] == 3 && mesh.triangles[t][1] == 3 ? 0 : 1) << t;
}

/// Edges between run the same way twice, as some CAD files have them.
TEST(FitSurfaces, EndsWhereTrianglesAreTurnedOver) {
  Mesh mesh = tilted_plane(12);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    if (t % 7 < 3) std::swap(mesh.triangles[t][1], mesh.triangles[t][2]);
  const FittedSurfaces surfaces = fitted(mesh, samples_of(mesh));
  std::size_t triangles = surfaces.facets.size();
  for (const FittedChart& chart : surfaces.charts) triangles += chart.triangles.size();
  EXPECT_EQ(triangles, mesh.triangles.size());
}

TEST(FitSurfaces, RefusesWhatIsNoLengthAndStopsOnRequest) {
  const Mesh mesh = tilted_plane(4);
  const Workers workers;
  for (const double bin : {0.0, -1.0, std::nan("")})
    EXPECT_EQ(fit_surfaces(mesh, samples_of(mesh), {}, bin, workers.context()).error().code, Code::BadParameter);
  EXPECT_EQ(fit_surfaces(mesh, samples_of(mesh), {0}, 1, workers.context()).error().code, Code::BadParameter);
  Workers stopped;
  stopped.cancel.set();
  EXPECT_EQ(fit_surfaces(mesh, samples_of(mesh), {}, 1, stopped.context()).error().code, Code::Cancelled);
}

}  // namespace
}  // namespace scanmill::surfaces
