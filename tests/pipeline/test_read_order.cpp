// SPDX-License-Identifier: Apache-2.0
// A cloud whose points were brought together is the same cloud.
#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <tuple>

#include "base/random.hpp"
#include "cloud/gathered_points.hpp"
#include "cloud/spatial_order.hpp"
#include "pipeline/surface.hpp"
#include "reduce/reduce.hpp"
#include "support/meshing.hpp"

namespace scanmill::pipeline {
namespace {

/// Points of a ball in no order, some of them finer than float32, in three views.
class Scattered final : public PointSource {
 public:
  explicit Scattered(std::size_t blocks) : blocks_(blocks) {}
  std::size_t block_count() const override { return blocks_; }
  std::uint64_t expected_points() const override { return blocks_ * kPerBlock; }
  Result<void> read_block(std::size_t number, PointBlock& out) const override {
    out.clear();
    out.view = ViewId{static_cast<std::uint32_t>(number % 3)};
    out.view_point.eye = Vec3{100, static_cast<double>(number % 3), 0};
    Random random(7, number, 1);
    for (std::size_t n = 0; n < kPerBlock; ++n) {
      const Vec3 d{random.gauss(), random.gauss(), random.gauss()};
      Vec3 p = d * (20 / norm(d));
      const auto single = [](double v) { return static_cast<double>(static_cast<float>(v)); };
      if (number % 2 == 0) p = {single(p.x), single(p.y), single(p.z)};
      out.positions.push_back(p);
      // Rows beyond 32 bits, and blocks whose rows go back.
      out.rows.push_back((number % 5) * 0xffffff00ull + (number / 5) * kPerBlock + n);
    }
    out.points_read = kPerBlock + 2;
    out.not_finite = 1;
    out.sensor_invalid = 1;
    return {};
  }

  static constexpr std::size_t kPerBlock = 3000;

 private:
  std::size_t blocks_;
};

/// Places, views, eyes and rows, sorted.
using Points = std::vector<std::tuple<double, double, double, std::uint32_t, double, std::uint64_t>>;
struct Content {
  Points points;
  std::uint64_t read = 0, not_finite = 0, invalid = 0;
};
Content content_of(const PointSource& source) {
  Content all;
  PointBlock block;
  for (std::size_t n = 0; n < source.block_count(); ++n) {
    EXPECT_TRUE(source.read_block(n, block).ok());
    for (std::size_t i = 0; i < block.positions.size(); ++i) {
      const Vec3 p = block.positions[i];
      all.points.emplace_back(p.x, p.y, p.z, index_of(block.view), block.view_point.eye->y, block.rows[i]);
    }
    all.read += block.points_read;
    all.not_finite += block.not_finite;
    all.invalid += block.sensor_invalid;
  }
  std::sort(all.points.begin(), all.points.end());
  return all;
}

TEST(GatheredPoints, AreTheSamePoints) {
  const Scattered points(40);
  const support::Workers workers(3);
  const auto blocks = spatial_order(points, workers.context(), [](int, const PointBlock&) {});
  ASSERT_TRUE(blocks.ok());
  const auto scatter = GatheredPoints::scatter_of(points);
  ASSERT_TRUE(scatter.ok());
  EXPECT_GT(*scatter, 0.4);
  const auto gathered = GatheredPoints::gather(points, blocks->bounds, workers.context());
  ASSERT_TRUE(gathered.ok()) << gathered.error().text();
  PointBlock one, other;
  ASSERT_TRUE(points.read_block(0, one).ok() && (*gathered)->read_block(0, other).ok());
  EXPECT_EQ(one.positions[0], other.positions[0]);
  EXPECT_EQ(one.rows[0], other.rows[0]);
  const Content before = content_of(points), after = content_of(**gathered);
  EXPECT_TRUE(before.points == after.points);
  EXPECT_EQ(std::tie(before.read, before.not_finite, before.invalid),
            std::tie(after.read, after.not_finite, after.invalid));
  const auto together = GatheredPoints::scatter_of(**gathered);
  ASSERT_TRUE(together.ok());
  EXPECT_LT(*together, 0.05);
}

TEST(GatheredPoints, AreNotWantedOfScanLines) {
  std::vector<Vec3> lines;  // slanting ones, over a box that is not flat
  for (int line = 0; line < 200; ++line)
    for (int n = 0; n < 200; ++n) lines.push_back({n + line * 0.5, line * 1.0, n * 0.7 + line * 0.2});
  const auto scatter = GatheredPoints::scatter_of(MemoryPoints(std::move(lines), {}, 2000));
  ASSERT_TRUE(scatter.ok());
  EXPECT_LT(*scatter, 0.1);
}

TEST(GatheredPoints, GiveTheSameMesh) {
  const Scattered points(60);
  const support::Workers workers(2);
  const Context context = workers.context();
  Bounds bounds;
  for (const auto& p : content_of(points).points) bounds.add(Vec3{std::get<0>(p), std::get<1>(p), std::get<2>(p)});
  const auto gathered = GatheredPoints::gather(points, bounds, context);
  ASSERT_TRUE(gathered.ok()) << gathered.error().text();
  const What what = support::what_of(0.5);
  const auto one = reduce::reduce_cloud(points, what.lattice, what.reduce, context);
  const auto other = reduce::reduce_cloud(**gathered, what.lattice, what.reduce, context);
  ASSERT_TRUE(one.ok() && other.ok());
  EXPECT_EQ(one->cloud.measured, other->cloud.measured);
  EXPECT_EQ(one->cloud.normal, other->cloud.normal);
  EXPECT_EQ(one->cloud.drop, other->cloud.drop);
  EXPECT_EQ(one->report.points_read, other->report.points_read);
  EXPECT_EQ(one->report.not_finite, other->report.not_finite);
  for (std::size_t n = 0; n < one->cloud.size(); ++n)
    ASSERT_TRUE(one->cloud.source[n].view == other->cloud.source[n].view &&
                one->cloud.source[n].row == other->cloud.source[n].row);
}

TEST(GatheredPoints, MayAllBeInOnePlace) {
  const MemoryPoints points(std::vector<Vec3>(1000, Vec3{1, 2, 3}), {}, 100);
  const support::Workers workers(2);
  Bounds bounds;
  bounds.add(Vec3{1, 2, 3});
  const auto gathered = GatheredPoints::gather(points, bounds, workers.context());
  ASSERT_TRUE(gathered.ok());
  std::set<std::uint64_t> rows;
  PointBlock block;
  for (std::size_t n = 0; n < (*gathered)->block_count(); ++n) {
    ASSERT_TRUE((*gathered)->read_block(n, block).ok());
    rows.insert(block.rows.begin(), block.rows.end());
  }
  EXPECT_EQ(rows.size(), 1000u);
}

}  // namespace
}  // namespace scanmill::pipeline
