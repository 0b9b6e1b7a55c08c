// SPDX-License-Identifier: Apache-2.0
// What reduction does with empty, broken and outsized input, and how it chooses a bin edge.
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <limits>
#include <thread>

#include "clouds.hpp"
#include "reduce/binning.hpp"
#include "reduce/reduce.hpp"

namespace scanmill::reduce {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

LatticeParams edge(double bin_mm) {
  LatticeParams lattice;
  lattice.bin_mm = bin_mm;
  return lattice;
}

Result<Reduction> run(const PointSource& points, const LatticeParams& lattice, const Params& params = {},
                      int threads = 1) {
  const ChunkLoop loop(threads);
  const CancelFlag cancel;
  return reduce_cloud(points, lattice, params, {loop, cancel});
}

void expect_error(const Result<Reduction>& result, Code code, const std::string& words) {
  ASSERT_FALSE(result.ok());
  EXPECT_EQ(name_of(result.error().code), std::string(name_of(code)));
  EXPECT_NE(result.error().message.find(words), std::string::npos) << result.error().message;
}

TEST(ReduceCloud, RefusesACloudWithoutAPoint) {
  expect_error(run(MemoryPoints({}), edge(1)), Code::BadInput, "no finite point");
  expect_error(run(MemoryPoints({{kNaN, 0, 0}, {0, -INFINITY, 0}}), edge(1)), Code::BadInput, "no finite point");
  LatticeParams bins;
  bins.target_bins = 100;
  expect_error(run(MemoryPoints({{kNaN, 0, 0}}), bins), Code::BadInput, "no finite point");
}

TEST(ReduceCloud, KeepsTheBinOfASinglePointAsIsolated) {
  const auto result = run(MemoryPoints({{kNaN, 0, 0}, {1.5, -2.5, 3.5}}, {}, 1), edge(1));
  ASSERT_TRUE(result.ok()) << result.error().text();
  const ReducedCloud& cloud = result->cloud;
  ASSERT_EQ(cloud.size(), 1u);
  EXPECT_EQ(cloud.key(0), (BinKey{1, -3, 3}));
  EXPECT_EQ(cloud.source[0], (SourceKey{ViewId{0}, 1}));
  EXPECT_EQ(cloud.drop[0], Drop::Isolated);
  EXPECT_EQ(cloud.projected[0], cloud.measured[0]);
  EXPECT_EQ(result->report.points_read, 2u);
  EXPECT_EQ(result->report.not_finite, 1u);
  EXPECT_EQ(result->report.points_used, 1u);
  EXPECT_EQ(result->report.kept, 0u);
  EXPECT_EQ(result->report.dropped_isolated, 1u);
}

TEST(ReduceCloud, WantsExactlyOneWayToSizeBins) {
  const MemoryPoints points({{0, 0, 0}});
  expect_error(run(points, {}), Code::BadParameter, "found 0 of");
  LatticeParams two = edge(1);
  two.target_bins = 10;
  expect_error(run(points, two), Code::BadParameter, "found 2 of");
  two.target_points = 10;
  expect_error(run(points, two), Code::BadParameter, "found 3 of");
}

TEST(ReduceCloud, ListsEveryParameterOutsideItsLimits) {
  Params params;
  params.max_centre_distance = 1.5;
  params.min_points_per_bin = 0;
  const auto result = run(MemoryPoints({{0, 0, 0}}), edge(-1), params);
  ASSERT_FALSE(result.ok());
  for (const char* name : {"bin_mm", "max_centre_distance", "min_points_per_bin"})
    EXPECT_NE(result.error().message.find(name), std::string::npos) << result.error().message;
}

TEST(ReduceCloud, RefusesACloudWiderThanItsBinsCanCount) {
  const double wide = 0x1p30;
  for (int axis = 0; axis < 3; ++axis) {
    Vec3 stray;
    (axis == 0 ? stray.x : axis == 1 ? stray.y : stray.z) = wide + 2048;
    expect_error(run(MemoryPoints({{0, 0, 0}, stray}, {}, 1), edge(1)), Code::BadInput, "2^30 bins wide");
    expect_error(run(MemoryPoints({{0, 0, 0}, -stray}), edge(1)), Code::BadInput, "2^30 bins wide");
    EXPECT_TRUE(run(MemoryPoints({{0, 0, 0}, stray * 0.5}), edge(1)).ok());
  }
  expect_error(run(MemoryPoints({{0, 0, 0}, {1e300, 0, 0}}), edge(1)), Code::BadInput, "2^30 bins wide");
  expect_error(run(MemoryPoints({{1e300, 0, 0}}), edge(1)), Code::BadInput, "2^30 bins wide");
}

TEST(ReduceCloud, RefusesPointsAtTheEndOfDouble) {
  for (const double far : {1e19, 1e300, 1.7e308}) {
    expect_error(run(MemoryPoints({{far, 0, 0}, {0, 0, 0}}), edge(1)), Code::BadInput, "2^30 bins wide");
    expect_error(run(MemoryPoints({{0, -far, 0}, {far, 0, 0}}), edge(1e-3)), Code::BadInput, "2^30 bins wide");
    LatticeParams bins;
    bins.target_bins = 100;
    expect_error(run(MemoryPoints({{-far, 0, 0}, {far, 0, 0}}), bins), Code::BadInput, "mm wide");
  }
  LatticeParams bins;
  bins.target_bins = 100;
  expect_error(run(MemoryPoints({{0, 0, 0}, {1e-310, 0, 0}}), bins), Code::BadInput, "coincide");
}

TEST(ReduceCloud, PutsTheFirstBinAtTheLowestCornerWhenAsked) {
  const TestCloud cloud = clouds::sphere(1);
  LatticeParams lattice = edge(1.3);
  lattice.origin = Origin::Bounds;
  const auto result = run(in_order(cloud, 100), lattice);
  ASSERT_TRUE(result.ok());
  Bounds bounds;
  for (const Sample& s : cloud.samples) bounds.add(s.position);
  EXPECT_EQ(result->cloud.lattice.origin, bounds.low);
  BinKey least{99, 99, 99};
  for (std::size_t row = 0; row < result->cloud.size(); ++row) {
    const BinKey key = result->cloud.key(row);
    least = {std::min(least.i, key.i), std::min(least.j, key.j), std::min(least.k, key.k)};
  }
  EXPECT_EQ(least, (BinKey{0, 0, 0}));
}

TEST(ReduceCloud, ComesNearTheWantedNumberOfBins) {
  for (const TestCloud& cloud : {clouds::sphere(1), clouds::torus(2), clouds::noise(3), clouds::far_away(4)})
    for (const double wanted : {50.0, 700.0}) {
      SCOPED_TRACE(cloud.name);
      LatticeParams lattice;
      lattice.target_bins = wanted;
      const auto result = run(in_order(cloud, 1000), lattice);
      ASSERT_TRUE(result.ok()) << result.error().text();
      // Bins come and go in steps; a few at 50.
      EXPECT_NEAR(static_cast<double>(result->report.bins), wanted, 0.05 * wanted + 3) << result->report.bin_mm;
      // Three digits, so that the edge can be written into a job.
      char text[32];
      std::snprintf(text, sizeof text, "%.3g", result->report.bin_mm);
      EXPECT_EQ(std::strtod(text, nullptr), result->report.bin_mm) << text;
    }
}

TEST(ReduceCloud, ComesNearTheWantedNumberOfPoints) {
  for (const TestCloud& cloud : {clouds::sphere(5), clouds::torus(6)}) {
    SCOPED_TRACE(cloud.name);
    LatticeParams lattice;
    lattice.target_points = 500;
    const auto result = run(in_order(cloud, 1000), lattice);
    ASSERT_TRUE(result.ok()) << result.error().text();
    EXPECT_NEAR(static_cast<double>(result->report.kept), 500, 30);
  }
}

TEST(ReduceCloud, FindsNoBinSizeForPointsThatCoincide) {
  LatticeParams lattice;
  lattice.target_bins = 10;
  expect_error(run(MemoryPoints(std::vector<Vec3>(20, Vec3{1, 2, 3})), lattice), Code::BadInput, "coincide");
}

TEST(ReduceCloud, RefusesMoreThanCanBeNumberedAndNamesABinThatWouldDo) {
  EXPECT_TRUE(check_numbers(kMostBins, kMostKept, 0.5).ok());
  const auto bins = check_numbers(4 * kMostBins, 0, 0.5), kept = check_numbers(kMostBins, kMostKept + 1, 0.5);
  ASSERT_FALSE(bins.ok() || kept.ok());
  EXPECT_EQ(bins.error().text(),
            "bins of 0.5 mm give 8,589,934,588 or more of them, at most 2,147,483,647 can be numbered; wanted bins of "
            "1.1 mm or more");
  EXPECT_EQ(kept.error().text(),
            "bins of 0.5 mm give 536,870,913 points of the mesh, at most 536,870,912 can be numbered; wanted bins of "
            "0.55 mm or more");
}

TEST(ReduceCloud, StopsWhenCancelled) {
  const ChunkLoop loop(2);
  CancelFlag cancel;
  cancel.set();
  expect_error(reduce_cloud(MemoryPoints({{0, 0, 0}}), edge(1), {}, {loop, cancel}), Code::Cancelled, "stopped");
}

}  // namespace
}  // namespace scanmill::reduce
