// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "base/digest.hpp"
#include "pipeline/bin_forecast.hpp"
#include "pipeline/cut_reduction.hpp"
#include "pipeline/cut_stars.hpp"
#include "pipeline/cut_surface.hpp"
#include "pipeline/cut_swaps.hpp"
#include "pipeline/part_forecast.hpp"
#include "pipeline/part_rows.hpp"
#include "support/meshing.hpp"
#include "support/temp_folder.hpp"

namespace scanmill::pipeline {
namespace {

constexpr double kEdge = 0.25;

/// Two noisy bumpy shells, far enough apart to leave bricks empty, in blocks of several views.
class Shells final : public PointSource {
 public:
  Shells(std::size_t blocks, std::size_t per_block, double thickness = 0.05, bool is_seen = true)
      : blocks_(blocks), per_block_(per_block), thickness_(thickness), is_seen_(is_seen) {}
  std::size_t block_count() const override { return blocks_; }
  std::uint64_t expected_points() const override { return blocks_ * per_block_; }
  Result<void> read_block(std::size_t number, PointBlock& out) const override {
    out.clear();
    out.view = ViewId{static_cast<std::uint32_t>(number / 4)};
    if (is_seen_) out.view_point.eye = Vec3{60, 0, 0};
    for (std::size_t n = 0; n < per_block_; ++n) {
      auto uniform = [&](std::uint64_t k) {
        return static_cast<double>(mix64(number * 1000003 + n * 17 + k) >> 11) * 0x1p-53;
      };
      Vec3 d{uniform(1) - 0.5, uniform(2) - 0.5, uniform(3) - 0.5};
      const double length = norm(d);
      if (length < 0.1) continue;
      d = d * (1 / length);
      const double radius = 6 + d.x * d.y * 0.8 + (uniform(4) - 0.5) * thickness_;
      out.positions.push_back(d * radius + (number % 2 ? Vec3{} : Vec3{20, 3, -7}));
      out.rows.push_back(number * per_block_ + n);
    }
    out.points_read = out.positions.size() + 1;
    out.not_finite = 1;
    return {};
  }

 private:
  std::size_t blocks_, per_block_;
  double thickness_;
  bool is_seen_;
};

struct Case {
  std::uint32_t brick_bins, pieces, batches;
  bool paper, edge_aware;
};

class CutReductions : public testing::TestWithParam<Case> {};

TEST_P(CutReductions, GiveTheReducedPointsOfTheWhole) {
  const Case& c = GetParam();
  const ChunkLoop loop(3);
  const CancelFlag cancel;
  const Context context{loop, cancel};
  const support::TempFolder folder;
  const Shells points(24, 4000);
  reduce::LatticeParams lattice;
  lattice.bin_mm = kEdge;
  reduce::Params params = c.paper ? reduce::Params::paper() : reduce::Params();
  params.edge_aware = c.edge_aware;
  const auto whole = reduce::reduce_cloud(points, lattice, params, context);
  ASSERT_TRUE(whole.ok()) << whole.error().text();

  const CutReduction cut(points, lattice, params,
                         {folder.path(), std::string(64, 'a'), c.pieces, c.batches, c.brick_bins});
  for (auto wave :
       waves_of({folder.path(), std::string(64, 'a'), c.pieces, c.batches, c.brick_bins}, params.representative)) {
    std::reverse(wave.begin(), wave.end());
    for (const PartTask& task : wave) {
      const auto made = cut.make(task, context);
      ASSERT_TRUE(made.ok()) << name_of(task) << ": " << made.error().text();
    }
  }
  const auto joined = join_reduction({folder.path(), std::string(64, 'a'), c.pieces, c.batches, c.brick_bins});
  ASSERT_TRUE(joined.ok()) << joined.error().text();
  const reduce::ReducedCloud &a = whole->cloud, &b = joined->cloud;
  EXPECT_EQ(a.bins, b.bins);
  EXPECT_EQ(a.measured, b.measured);
  EXPECT_EQ(a.projected, b.projected);
  EXPECT_EQ(a.normal, b.normal);
  EXPECT_EQ(a.source, b.source);
  EXPECT_EQ(a.counts, b.counts);
  EXPECT_EQ(a.drop, b.drop);
  EXPECT_EQ(a.residual, b.residual);
  EXPECT_EQ(a.variation, b.variation);
  EXPECT_EQ(a.plane_distance, b.plane_distance);
  EXPECT_EQ(a.frame_valid, b.frame_valid);
  EXPECT_EQ(a.sign_known, b.sign_known);
  EXPECT_EQ(whole->report.points_read, joined->report.points_read);
  EXPECT_EQ(whole->report.not_finite, joined->report.not_finite);
  EXPECT_EQ(whole->report.bounds.low, joined->report.bounds.low);
  EXPECT_EQ(whole->report.median_residual, joined->report.median_residual);
  EXPECT_EQ(whole->report.noise, joined->report.noise);
  EXPECT_EQ(whole->report.kept, joined->report.kept);
  const auto bricks = cut.bricks();
  ASSERT_TRUE(bricks.ok());
  EXPECT_EQ(bricks->bins, a.size());
  EXPECT_TRUE(c.brick_bins > 8 || bricks->bricks > 200) << bricks->bricks;
}

INSTANTIATE_TEST_SUITE_P(Cuts, CutReductions,
                         testing::Values(Case{8, 5, 7, false, false}, Case{32, 3, 4, false, true},
                                         Case{64, 24, 64, false, false}, Case{256, 1, 1, false, false},
                                         Case{32, 40, 3, true, false}, Case{1024, 2, 5, true, false}));

/// A plate of points in lines, each a little nearer to its bin's centre than the one before and within c2 of it:
/// whether one stays hangs on the next, and so on to the end of the line.
class Plate final : public PointSource {
 public:
  std::size_t block_count() const override { return kLines; }
  std::uint64_t expected_points() const override { return kLines * kPoints; }
  Result<void> read_block(std::size_t line, PointBlock& out) const override {
    out.clear();
    out.view = ViewId{0};
    for (std::size_t n = 0; n < kPoints; ++n) {
      const double x = 0.9 + 0.999 * static_cast<double>(n), y = 0.1 + 1.2 * static_cast<double>(line);
      out.positions.push_back({kEdge * x, kEdge * y, kEdge * 0.5});
      out.rows.push_back(line * kPoints + n);
    }
    out.points_read = kPoints;
    return {};
  }

 private:
  static constexpr std::size_t kLines = 60, kPoints = 160;
};

TEST(PartForecast, IsWhatThePartsTakeWaveByWave) {
  const ChunkLoop loop(2);
  const CancelFlag cancel;
  const Context context{loop, cancel};
  const Shells points(24, 4000);
  for (const bool paper : {false, true}) {
    const support::TempFolder folder;
    What what;
    what.lattice.bin_mm = kEdge;
    if (paper) what.reduce = reduce::Params::paper();
    const Cut cut{folder.path(), std::string(64, 'a'), 3, 4, 16};
    const auto counts = count_bins(points, what, cut, context);
    ASSERT_TRUE(counts.ok()) << counts.error().text();
    const auto forecast = forecast_waves(cut, what, *counts);
    ASSERT_EQ(forecast.size(), scan_waves(cut, what).size() + 2);
    double cpu = 0;
    for (const WaveForecast& wave : forecast) cpu += wave.cpu;
    EXPECT_NEAR(cpu, 1, 1e-9);
    const CutReduction reduction(points, what.lattice, what.reduce, cut);
    std::size_t n = 1;  // behind the count
    for (const auto& wave : waves_of(cut, what.reduce.representative)) {
      for (const PartTask& task : wave) ASSERT_TRUE(reduction.make(task, context).ok()) << name_of(task);
      std::uint64_t there = 0;
      for (const auto& file : std::filesystem::directory_iterator(folder.path())) there += file.file_size();
      const std::uint64_t loose = 200 << 10;  // blocks of the disk, for every file
      EXPECT_LE(there, forecast[n].disk) << name_of(wave[0]) << (paper ? ", paper" : "");
      EXPECT_LE(forecast[n].disk, there + there / 50 + loose * (1 + n)) << name_of(wave[0]) << (paper ? ", paper" : "");
      remove_read_parts(cut, wave[0].stage);
      ++n;
    }
    EXPECT_EQ(counts->of_all, reduction.bricks()->bins);
  }
}

TEST(PartForecast, CountsAShareOfTheLeavesOfALargeCloud) {
  const Shells points(24, 4000);
  reduce::LatticeParams lattice;
  lattice.bin_mm = 0.05;
  const auto frame = reduce::frame_of_parts(points, lattice, reduce::Params());
  ASSERT_TRUE(frame.ok());
  PointBlock block;
  std::vector<std::uint64_t> found;
  for (const int one_in : {1, 4}) {
    BinForecast whole(*frame, 2, one_in), halves[2] = {{*frame, 1, one_in}, {*frame, 1, one_in}};
    for (std::size_t n = 0; n < points.block_count(); ++n) {
      ASSERT_TRUE(points.read_block(n, block).ok());
      whole.look(static_cast<int>(n % 2), block);
      halves[n % 3 == 0].look(0, block);
    }
    found.push_back(whole.bins());
    halves[0].add(halves[1]);
    EXPECT_EQ(halves[0].bins(), found.back()) << "one in " << one_in;
  }
  EXPECT_GT(found[0], 50000u);
  EXPECT_NEAR(static_cast<double>(found[1]), static_cast<double>(found[0]), 0.1 * static_cast<double>(found[0]));
}

TEST(CutPlate, IsThinnedAsAWholeWhereBricksCannotTell) {
  const ChunkLoop loop(2);
  const CancelFlag cancel;
  const Context context{loop, cancel};
  const support::TempFolder folder;
  const Plate points;
  reduce::LatticeParams lattice;
  lattice.bin_mm = kEdge;
  reduce::Params params;
  params.representative = reduce::Representative::Centre;
  params.min_neighbour_distance = 1;
  const auto whole = reduce::reduce_cloud(points, lattice, params, context);
  ASSERT_TRUE(whole.ok()) << whole.error().text();
  const Cut cut{folder.path(), std::string(64, 'a'), 2, 3, 32};
  const CutReduction reduction(points, lattice, params, cut);
  for (const auto& wave : waves_of(cut, params.representative))
    for (const PartTask& task : wave) ASSERT_TRUE(reduction.make(task, context).ok()) << name_of(task);
  std::uint64_t open = 0;
  for (std::uint32_t batch = 0; batch < cut.batches; ++batch) {
    const auto file = open_part(cut, {PartStage::Thin, batch});
    ASSERT_TRUE(file);
    std::vector<ThinRow> rows(file->rows());
    ASSERT_TRUE(file->read_rows(0, std::span(rows)).ok());
    for (const ThinRow& row : rows) open += row.open;
  }
  EXPECT_GT(open, 0u) << "nothing to settle: the test shows nothing";
  const auto joined = join_reduction(cut);
  ASSERT_TRUE(joined.ok()) << joined.error().text();
  EXPECT_EQ(whole->cloud.drop, joined->cloud.drop);
}

/// From ballots of bricks that hold a handful of points each.
void expect_the_surface_of_the_whole(const Shells& points) {
  const ChunkLoop loop(2);
  const CancelFlag cancel;
  const Context context{loop, cancel};
  const What what = support::what_of(kEdge);
  NoProgress quiet;
  const auto whole = reduce::reduce_cloud(points, what.lattice, what.reduce, context);
  ASSERT_TRUE(whole.ok()) << whole.error().text();
  const auto wanted = mesh_surface(whole->cloud, whole->report.bounds, what, context, quiet);
  ASSERT_TRUE(wanted.ok()) << wanted.error().text();
  ASSERT_GT(wanted->stars.candidates, 20u);
  for (const std::uint32_t brick_bins : {8u, 32u, 1024u}) {
    const support::TempFolder folder;
    const Cut cut{folder.path(), std::string(64, 'a'), 3, 5, brick_bins};
    const CutReduction reduction(points, what.lattice, what.reduce, cut);
    for (const auto& wave : waves_of(cut, what.reduce.representative))
      for (const PartTask& task : wave) ASSERT_TRUE(reduction.make(task, context).ok()) << name_of(task);
    for (std::uint32_t batch = cut.batches; batch-- > 0;) ASSERT_TRUE(star_batch(cut, batch, what, context).ok());
    auto ballots = read_ballots(cut);
    ASSERT_TRUE(ballots.ok()) << ballots.error().text();
    const auto found =
        mesh_surface(whole->cloud, whole->report.bounds, what, context, quiet, std::move(ballots).value());
    ASSERT_TRUE(found.ok()) << found.error().text();
    EXPECT_EQ(wanted->mesh.triangles, found->mesh.triangles) << brick_bins;
    EXPECT_EQ(wanted->mesh.positions, found->mesh.positions) << brick_bins;
    EXPECT_EQ(std::memcmp(&wanted->stars, &found->stars, sizeof wanted->stars), 0) << brick_bins;
  }
}

TEST(CutStars, GiveTheSurfaceOfTheWhole) { expect_the_surface_of_the_whole(Shells(24, 4000)); }

/// No side is known, and triangles contradict each other everywhere.
TEST(CutStars, GiveTheTangleOfTheWhole) { expect_the_surface_of_the_whole(Shells(24, 1500, 3, false)); }

TEST(CutSwaps, GiveTheMeshOfTheWhole) {
  const Shells points(24, 4000);
  const ChunkLoop loop(2);
  const CancelFlag cancel;
  const Context context{loop, cancel};
  const What what = support::what_of(kEdge);
  NoProgress quiet;
  const auto whole = reduce::reduce_cloud(points, what.lattice, what.reduce, context);
  ASSERT_TRUE(whole.ok()) << whole.error().text();
  auto wanted = mesh_surface(whole->cloud, whole->report.bounds, what, context, quiet);
  ASSERT_TRUE(wanted.ok()) << wanted.error().text();
  const auto before = wanted->mesh.triangles;
  const auto report = optimise_surface(*wanted, what, kEdge, context, quiet);
  ASSERT_TRUE(report.ok()) << report.error().text();
  ASSERT_NE(wanted->mesh.triangles, before);
  for (const std::uint32_t brick_bins : {8u, 32u, 1024u}) {
    const support::TempFolder folder;
    const Cut cut{folder.path(), std::string(64, 'a'), 3, 5, brick_bins};
    const CutReduction reduction(points, what.lattice, what.reduce, cut);
    for (const auto& wave : waves_of(cut, what.reduce.representative))
      for (const PartTask& task : wave) ASSERT_TRUE(reduction.make(task, context).ok()) << name_of(task);
    for (std::uint32_t batch = 0; batch < cut.batches; ++batch) ASSERT_TRUE(star_batch(cut, batch, what, context).ok());
    ASSERT_TRUE(mesh_cut(cut, what, context, quiet).ok());
    for (std::uint32_t batch = cut.batches; batch-- > 0;) ASSERT_TRUE(swap_batch(cut, batch, what, context).ok());
    ASSERT_TRUE(join_swaps(cut, what, context, quiet).ok());
    const auto found = join_surface(cut);
    ASSERT_TRUE(found.ok()) << found.error().text();
    EXPECT_EQ(wanted->mesh.triangles, found->surface.mesh.triangles) << brick_bins;
    EXPECT_EQ(wanted->mesh.patch, found->surface.mesh.patch) << brick_bins;
    EXPECT_EQ(wanted->patches.rank, found->surface.patches.rank) << brick_bins;
    EXPECT_EQ(report->smooth.swaps, found->swaps.smooth.swaps) << brick_bins;
    EXPECT_EQ(report->feature.rounds, found->swaps.feature.rounds) << brick_bins;
    EXPECT_EQ(report->feature.angle_p5_after_deg, found->swaps.feature.angle_p5_after_deg) << brick_bins;
    EXPECT_EQ(report->after_feature.dihedral_sum_deg, found->swaps.after_feature.dihedral_sum_deg) << brick_bins;
  }
}

struct SmallCut : testing::Test {
  SmallCut() { lattice.bin_mm = kEdge; }
  const ChunkLoop loop{1};
  const CancelFlag cancel;
  const Context context{loop, cancel};
  const support::TempFolder folder;
  const Shells points{4, 2000};
  reduce::LatticeParams lattice;
};

TEST_F(SmallCut, MakesAPartOfAnotherIdentityOrACutOneAgain) {
  Cut first{folder.path(), std::string(64, 'a'), 2, 2, 32}, second = first;
  second.identity = std::string(64, 'b');
  const PartTask task{PartStage::Map, 0};
  ASSERT_TRUE(CutReduction(points, lattice, {}, first).make(task, context).ok());
  EXPECT_TRUE(is_done(first, task));
  EXPECT_FALSE(is_done(second, task));
  const std::string path = folder.path() + "/map-0.part";
  std::ifstream in(path, std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(in)), {});
  for (const std::size_t cut_at : {std::size_t{0}, std::size_t{100}, bytes.size() / 2, bytes.size() - 1}) {
    std::ofstream(path, std::ios::binary) << bytes.substr(0, cut_at);
    EXPECT_FALSE(is_done(first, task)) << cut_at;
  }
  ASSERT_TRUE(CutReduction(points, lattice, {}, first).make(task, context).ok());
  std::ifstream again(path, std::ios::binary);
  EXPECT_EQ(bytes, std::string((std::istreambuf_iterator<char>(again)), {}));
}

TEST_F(SmallCut, NamesThePartThatIsMissing) {
  const Cut cut{folder.path(), std::string(64, 'a'), 2, 2, 32};
  const auto made = CutReduction(points, lattice, {}, cut).make({PartStage::Gather, 0}, context);
  ASSERT_FALSE(made.ok());
  EXPECT_NE(made.error().text().find("the task 'map 0' makes it"), std::string::npos) << made.error().text();
}

}  // namespace
}  // namespace scanmill::pipeline
