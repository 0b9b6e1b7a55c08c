// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <tuple>

#include "base/digest.hpp"
#include "pipeline/scan_points.hpp"
#include "support/temp_folder.hpp"

namespace scanmill::pipeline {
namespace {

using support::TempFolder;

ScanSpec spec_of(std::vector<ViewSpec> views) {
  ScanSpec scan;
  scan.name = "scan";
  scan.views = std::move(views);
  return scan;
}

ViewSpec view_of(const std::string& path) {
  ViewSpec view;
  view.path = path;
  return view;
}

std::vector<PointBlock> blocks_of(const ScanPoints& points) {
  std::vector<PointBlock> blocks(points.block_count());
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const auto read = points.read_block(i, blocks[i]);
    if (!read.ok()) ADD_FAILURE() << read.error().text();
  }
  return blocks;
}

TEST(ScanPoints, AppliesUnitsPosesAndViewDirections) {
  const TempFolder folder;
  folder.write("a.xyz", "1 2 3\nnan 0 0\n");
  folder.write("b.xyz", "1 0 0\n2 0 0\n");
  ViewSpec posed = view_of("b.xyz");
  posed.pose = *pose_from_quaternion(0, 0, std::sqrt(0.5), std::sqrt(0.5), {5, 0, 0});
  posed.view_point.eye = Vec3{0, 0, 0};
  posed.view_point.direction = Vec3{1, 0, 0};
  ViewSpec in_units = view_of("a.xyz");
  in_units.pose.translation = {1, 0, 0};
  in_units.pose_in_file_units = true;
  ViewSpec missing = view_of("aa.xyz");
  missing.missing = true;
  const auto points = ScanPoints::open(folder.path(), spec_of({in_units, missing, posed}), 10);
  ASSERT_TRUE(points.ok()) << points.error().text();
  EXPECT_EQ((*points)->expected_points(), 4u);
  const auto blocks = blocks_of(**points);
  ASSERT_EQ(blocks.size(), 2u);
  EXPECT_EQ(blocks[0].view, ViewId{0});
  EXPECT_EQ(blocks[0].positions, (std::vector<Vec3>{{20, 20, 30}}));
  EXPECT_EQ(blocks[1].view, ViewId{2});
  EXPECT_NEAR(norm(blocks[1].positions[0] - Vec3{5, 10, 0}), 0, 1e-12);
  EXPECT_EQ(*blocks[1].view_point.eye, (Vec3{5, 0, 0}));
  EXPECT_NEAR(norm(*blocks[1].view_point.direction - Vec3{0, 1, 0}), 0, 1e-12);
  const auto counts = (*points)->counts();
  EXPECT_EQ(counts[0].points_read, 2u);
  EXPECT_EQ(counts[0].not_finite, 1u);
  EXPECT_EQ(counts[1].kept(), 2u);
  PointBlock again;
  ASSERT_TRUE((*points)->read_block(0, again).ok());
  EXPECT_EQ((*points)->counts()[0].points_read, 2u);
  ScanSpec own_units = spec_of({view_of("b.xyz")});
  own_units.units_mm = 1000;
  EXPECT_EQ(blocks_of(**ScanPoints::open(folder.path(), own_units, 10))[0].positions[0], (Vec3{1000, 0, 0}));
}

TEST(ScanPoints, ChecksContentAndChange) {
  const TempFolder folder;
  folder.write("a.xyz", "1 2 3\n");
  const ChunkLoop loop(2);
  const CancelFlag cancel;
  const Context context{loop, cancel};
  ViewSpec view = view_of("a.xyz");
  view.expected_sha256 = sha256_hex("1 2 3\n");
  const auto points = ScanPoints::open(folder.path(), spec_of({view}), 1);
  ASSERT_TRUE(points.ok());
  EXPECT_EQ((*points)->digests(context)->at(0), view.expected_sha256);
  EXPECT_TRUE((*points)->verify_unchanged().ok());
  view.expected_sha256 = std::string(64, '0');
  const auto wrong = (*ScanPoints::open(folder.path(), spec_of({view}), 1))->digests(context);
  ASSERT_FALSE(wrong.ok());
  EXPECT_EQ(wrong.error().code, Code::BadInput);
  EXPECT_EQ(wrong.error().where, "a.xyz");
  folder.write("a.xyz", "1 2 3\n4 5 6\n");
  const auto changed = (*points)->verify_unchanged();
  ASSERT_FALSE(changed.ok());
  EXPECT_EQ(changed.error().where, "a.xyz");
}

TEST(ScanPoints, RefusesScansWithoutPoints) {
  const TempFolder folder;
  folder.write("empty.ply", "");
  folder.write(
      "none.ply",
      "ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float y\nproperty float z\nend_header\n");
  for (const char* file : {"empty.ply", "none.ply", "not-there.ply"}) {
    const auto points = ScanPoints::open(folder.path(), spec_of({view_of(file)}), 1);
    ASSERT_FALSE(points.ok()) << file;
    EXPECT_EQ(points.error().code, Code::BadInput);
    EXPECT_EQ(points.error().where, file) << points.error().text();
  }
  ScanSpec broken = spec_of({});
  broken.broken = "plan.yaml:1:1: wrong";
  EXPECT_EQ(ScanPoints::open(folder.path(), broken, 1).error().message, broken.broken);
}

/// Median over the views of the best share of 1 mm voxels that another view has too.
double median_overlap(const ScanPoints& points) {
  using Voxel = std::tuple<int, int, int>;
  std::vector<std::set<Voxel>> voxels(points.views().size());
  for (const PointBlock& block : blocks_of(points))
    for (const Vec3& p : block.positions)
      voxels[index_of(block.view)].insert(
          {static_cast<int>(std::floor(p.x)), static_cast<int>(std::floor(p.y)), static_cast<int>(std::floor(p.z))});
  std::vector<double> best;
  for (std::size_t i = 0; i < voxels.size(); ++i) {
    double most = 0;
    for (std::size_t j = 0; j < voxels.size(); ++j) {
      if (j == i) continue;
      const auto shared =
          std::count_if(voxels[i].begin(), voxels[i].end(), [&](const Voxel& v) { return voxels[j].contains(v); });
      most = std::max(most, static_cast<double>(shared) / static_cast<double>(voxels[i].size()));
    }
    best.push_back(most);
  }
  std::sort(best.begin(), best.end());
  return (best[best.size() / 2] + best[(best.size() - 1) / 2]) / 2;
}

TEST(ScanPoints, LaysTheBunnyViewsOverEachOther) {
  const std::string data = support::data_folder();
  if (data.empty()) GTEST_SKIP() << "no development data";
  const std::string folder = data + "/range-views/bunny";
  const auto found = discover(folder, false);
  ASSERT_TRUE(found.ok());
  const auto points = ScanPoints::open(folder, found->scans[0], 1000);
  ASSERT_TRUE(points.ok()) << points.error().text();
  EXPECT_EQ((*points)->expected_points(), 362272u);
  EXPECT_GT(median_overlap(**points), 0.5);
  std::uint64_t kept = 0;
  for (const ViewCounts& counts : (*points)->counts()) kept += counts.kept();
  EXPECT_EQ(kept, 362272u);
  ScanSpec plain_reading = found->scans[0];
  for (ViewSpec& view : plain_reading.views) {
    const Vec3 translation = view.pose.translation;
    view.pose.translation = {};
    view.pose = view.pose.inverse();
    view.pose.translation = translation;
  }
  EXPECT_LT(median_overlap(**ScanPoints::open(folder, plain_reading, 1000)), 0.2);
}

TEST(ImplausibleSize, GuessesTheUnit) {
  const Bounds small{{0, 0, 0}, {0.156, 0.152, 0.118}};
  EXPECT_EQ(implausible_size(small, 1, 1),
            "size 0.16 x 0.15 x 0.12 mm cannot be; the numbers look like metres: set units to m");
  const Bounds part{{0, 0, 0}, {60, 40, 30}};
  EXPECT_EQ(implausible_size(part, 1, 1), "");
  EXPECT_EQ(implausible_size(part, 1, 0), "");
  EXPECT_EQ(implausible_size(part, 1, 20),
            "size 60 x 40 x 30 mm is less than 4 bins of 20 mm; choose a lattice.bin_mm of at most 3, or set units if "
            "the numbers are in another unit");
  EXPECT_EQ(
      implausible_size({{0, 0, 0}, {0.8, 0.6, 0.5}}, 1, 0.3),
      "size 0.8 x 0.6 x 0.5 mm cannot be; the numbers look like metres or centimetres or inches: set units to m or "
      "cm or in");
  const Bounds huge{{0, 0, 0}, {160000, 150000, 120000}};
  EXPECT_EQ(implausible_size(huge, 1000, 1),
            "size 160000 x 150000 x 120000 mm cannot be; the numbers look like millimetres: set units to mm");
  EXPECT_EQ(implausible_size(huge, 1000, 500), "");  // a survey in metres
  EXPECT_EQ(implausible_size({}, 1, 1), "");
  EXPECT_EQ(implausible_size({{0, 0, 0}, {0, 0, 0}}, 1, 1, 1234),
            "all 1,234 points coincide; wanted points of a surface");
  EXPECT_EQ(implausible_size({{0, 0, 0}, {0, 0, 0}}, 1, 0, 1), "holds one point; wanted points of a surface");
}

}  // namespace
}  // namespace scanmill::pipeline
