// SPDX-License-Identifier: Apache-2.0
// What every mesh keeps, whatever the cloud: shapes x noise x profile x bin edge.
#include <gtest/gtest.h>

#include <cctype>
#include <cmath>

#include "support/meshing.hpp"
#include "support/shapes.hpp"

namespace scanmill::support {
namespace {

using pipeline::Profile;

constexpr double kNoises[] = {0, 0.02, 0.1, 0.2};  // of the bin edge
constexpr double kBins[] = {1.0, 1.375};           // mm
constexpr double kTolerance = 0.12;  // of area and volume: chords lie inside, creases are cut, noise is rough

struct Case {
  const Shape& shape;
  double noise, bin;
  Profile profile;
};

void expect_honest_surface(const Case& c, const Meshed& meshed, const MeshFindings& found) {
  const auto& report = meshed.surface;
  if (c.shape.components) {
    EXPECT_EQ(found.components, *c.shape.components);
  }
  if (c.shape.euler) {
    EXPECT_EQ(found.euler, *c.shape.euler);
  }
  if (c.shape.loops) {
    EXPECT_EQ(found.loops, *c.shape.loops);
  }
  if (c.shape.closed) {
    EXPECT_EQ(found.boundary_edges, 0u);
    EXPECT_GT(found.volume, 0) << "inside out";
  }
  if (c.shape.area) {
    EXPECT_NEAR(found.area / *c.shape.area, 1, kTolerance);
  }
  if (c.shape.volume) {
    EXPECT_NEAR(found.volume / *c.shape.volume, 1, kTolerance);
  }
  const double used = static_cast<double>(report.kept_used) / static_cast<double>(meshed.reduction.report.kept);
  EXPECT_GE(used, c.shape.least_used);
}

void expect_own_counts_agree(const Meshed& meshed, const MeshFindings& found) {
  const auto& s = meshed.surface;
  EXPECT_EQ(s.loops.size(), found.loops);
  EXPECT_EQ(s.components, found.components);
  EXPECT_EQ(s.mesh.positions.size(), found.vertices) << "a vertex without triangle";
  EXPECT_LE(s.kept_used + s.kept_in_strays, meshed.reduction.report.kept);
  for (std::size_t v = 0; v < s.vertex_row.size(); ++v)
    ASSERT_EQ(s.mesh.positions[v], meshed.reduction.cloud.measured[s.vertex_row[v]])
        << "a vertex that was not measured";
}

class OnShapes : public testing::TestWithParam<std::size_t> {};

TEST_P(OnShapes, KeepsItsPromises) {
  const Shape& shape = shapes()[GetParam()];
  for (const double bin : kBins)
    for (const double noise : kNoises)
      for (const Profile profile : {Profile::Scan, Profile::Paper}) {
        const Case c{shape, noise, bin, profile};
        SCOPED_TRACE(shape.name + ", noise " + std::to_string(noise) + " h, bin " + std::to_string(bin) +
                     (profile == Profile::Scan ? ", scan" : ", paper"));
        const pipeline::What what = what_of(bin, profile);
        const auto meshed = mesh_points(with_noise(shape.points(bin), noise * bin, 7), what);
        ASSERT_TRUE(meshed.ok()) << meshed.error().text();
        const MeshFindings found = judge(*meshed, what);
        EXPECT_TRUE(found.sound()) << found;
        expect_own_counts_agree(*meshed, found);
        if (noise <= shape.greatest_noise) expect_honest_surface(c, *meshed, found);
        if (testing::Test::HasFailure()) {
          ADD_FAILURE() << found << "\nused " << meshed->surface.kept_used << " of " << meshed->reduction.report.kept;
          return;
        }
      }
}

/// The zeros hold under any limits, those included at which reach and windows change their width in bins.
TEST(EveryMesh, KeepsTheZerosUnderOtherLimits) {
  struct Limits {
    double g1, g2;
  };
  for (const char* name : {"box", "step", "touching spheres", "noise ball"})
    for (const Limits limits : {Limits{1, 5}, Limits{1.7320, 20}, Limits{2.5, 0}, Limits{2.5, 35}, Limits{0.3, 5}}) {
      SCOPED_TRACE(std::string(name) + ", g1 " + std::to_string(limits.g1) + ", g2 " + std::to_string(limits.g2));
      pipeline::What what = what_of(1.25);
      what.grow.range_bins = limits.g1;
      what.grow.min_angle_deg = limits.g2;
      const auto meshed = mesh_points(with_noise(shape_named(name).points(1.25), 0.15, 9), what);
      if (!meshed.ok()) {
        EXPECT_EQ(meshed.error().code, Code::BadInput) << "no triangle at all is an honest answer";
        EXPECT_LT(limits.g1, 0.5);
        continue;
      }
      const MeshFindings found = judge(*meshed, what);
      EXPECT_TRUE(found.sound()) << found;
    }
}

INSTANTIATE_TEST_SUITE_P(EveryMesh, OnShapes, testing::Range<std::size_t>(0, shapes().size()),
                         [](const auto& instance) {
                           std::string name = shapes()[instance.param].name;
                           for (char& c : name)
                             if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '_';
                           return name;
                         });

/// Rows of points that beat with the bins: a plane seen at a constant pitch of half a bin, tilted, or a wavy sheet.
TEST(RangeMap, OfRegularPitchStaysWhole) {
  constexpr int kSide = 90;
  constexpr double kPitch = 0.5;
  for (int shape = 0; shape < 11; ++shape) {
    std::vector<Vec3> points;
    for (int i = 0; i < kSide * kSide; ++i) {
      const double x = kPitch * (i / kSide), y = kPitch * (i % kSide);
      const double wave = 8 * std::sin(x / 9), hills = 4 * std::sin(x / 8) * std::cos(y / 8);
      points.push_back({x, y, shape == 9 ? wave : shape == 10 ? hills : 0.125 * shape * x});
    }
    for (const double bin : {0.9, 1.0, 1.1, 1.3}) {
      SCOPED_TRACE("shape " + std::to_string(shape) + ", bin " + std::to_string(bin));
      const auto what = what_of(bin);
      const auto meshed = mesh_points(points, what);
      ASSERT_TRUE(meshed.ok()) << meshed.error().text();
      EXPECT_EQ(meshed->surface.loops.size(), 1u);
      EXPECT_EQ(meshed->surface.components, 1u);
    }
  }
}

}  // namespace
}  // namespace scanmill::support
