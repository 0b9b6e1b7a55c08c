// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "base/random.hpp"
#include "clean/clean.hpp"
#include "support/meshing.hpp"
#include "support/shapes.hpp"

namespace scanmill::clean {
namespace {

using support::Workers;

/// What stays, in block order, with its rows; and what the wrapper tells about the rest.
struct Cleaned {
  std::vector<Vec3> kept;
  std::vector<std::uint64_t> rows;
  RuleCounts counts;
  std::vector<RuleCounts> by_view;
  std::vector<RemovedPoint> sample;
  std::shared_ptr<const Rules> rules;
};

Result<Cleaned> cleaned(const PointSource& points, const Params& params, int threads = 1, double bin_mm = 1,
                        std::size_t sample = 1000) {
  const Workers workers(threads);
  Cleaned out;
  TRY_ASSIGN(out.rules, fix_rules(points, params, bin_mm, 0, workers.context()));
  const CleanPoints clean(points, out.rules, sample);
  std::vector<PointBlock> blocks(clean.block_count());
  std::vector<Result<void>> read(blocks.size());
  for (int pass = 0; pass < 2; ++pass)  // reading again counts nothing twice
    workers.loop.run(blocks.size(), [&](std::size_t number, int) {
      const std::size_t block = pass == 0 ? blocks.size() - 1 - number : number;
      read[block] = clean.read_block(block, blocks[block]);
    });
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    TRY(read[i]);
    out.kept.insert(out.kept.end(), blocks[i].positions.begin(), blocks[i].positions.end());
    out.rows.insert(out.rows.end(), blocks[i].rows.begin(), blocks[i].rows.end());
  }
  out.counts = clean.counts();
  out.by_view = clean.counts_by_view();
  out.sample = clean.removed_sample();
  return out;
}
Cleaned good(const std::vector<Vec3>& points, const Params& params, int threads = 1, std::size_t block = 4096) {
  auto out = cleaned(MemoryPoints(points, {}, block), params, threads);
  EXPECT_TRUE(out.ok()) << out.error().text();
  return out.ok() ? std::move(*out) : Cleaned{};
}
std::string failure(const std::vector<Vec3>& points, const Params& params, double bin_mm = 1) {
  const auto out = cleaned(MemoryPoints(points), params, 1, bin_mm);
  return out.ok() ? "no error" : out.error().text();
}

/// A turned deck with noise, and a box standing 0.5 mm and more above it.
///
///            +-----+
///            | box |
///   ---------+-----+---------  deck
struct DeckScene {
  static constexpr std::size_t kDeck = 20000, kBox = 15000;
  std::vector<Vec3> points;
  Vec3 up = unit({0.1, -0.2, 1}), at{100, 200, 300};
  DeckScene() {
    Random random(3, 1, 4);
    const Vec3 x = perpendicular(up), y = cross(up, x);
    for (std::size_t i = 0; i < kDeck; ++i)
      points.push_back(at + x * random.uniform(-60, 60) + y * random.uniform(-60, 60) + up * (0.05 * random.gauss()));
    for (const Vec3& p : support::box_points({0, 0, 10.6}, {30, 30, 20}, kBox, 5))
      points.push_back(at + x * p.x + y * p.y + up * p.z);
  }
};

TEST(CleanPoints, PassesEverythingWithoutRules) {
  const auto points = support::sphere_points({0, 0, 0}, 10, 10000, 1);
  const Cleaned out = good(points, Params());
  EXPECT_FALSE(Params().any());
  EXPECT_EQ(out.kept, points);
  EXPECT_EQ(out.counts.removed(), 0u);
  EXPECT_EQ(out.counts[Rule::Kept], points.size());
}

TEST(CleanPoints, BoxesAreHalfOpenAndTheFirstRuleCounts) {
  std::vector<Vec3> points;
  for (int i = 0; i < 10; ++i) points.push_back({double(i), 0, 0});
  Params params;
  params.keep_box = Box{{1, -1, -1}, {8, 1, 1}};
  params.remove_box = {{{3, -1, -1}, {5, 1, 1}}, {{4, -1, -1}, {6, 1, 1}}, {{0, -1, -1}, {1, 1, 1}}};
  params.remove_plane = PlaneRule{};
  params.remove_plane->point = Vec3{7, 0, 0};
  params.remove_plane->normal = Vec3{-2, 0, 0};
  params.remove_plane->distance_mm = 0.5;
  const Cleaned out = good(points, params);
  EXPECT_EQ(out.rows, (std::vector<std::uint64_t>{1, 2, 6}));
  EXPECT_EQ(out.counts[Rule::KeepBox], 3u);    // 0, 8, 9
  EXPECT_EQ(out.counts[Rule::RemoveBox], 3u);  // 3, 4, 5
  EXPECT_EQ(out.counts[Rule::OnPlane], 1u);    // 7
  EXPECT_EQ(summary_of(out.counts), "keep_box 3, remove_box 3, remove_plane 1");
}

TEST(CleanPoints, RemovesWhatLiesBelowAGivenPlaneWhenAsked) {
  std::vector<Vec3> points;
  for (int i = -5; i <= 5; ++i) points.push_back({0, 0, double(i)});
  Params params;
  params.remove_plane = PlaneRule{};
  params.remove_plane->point = Vec3{9, 9, 0};
  params.remove_plane->normal = Vec3{0, 0, 10};
  params.remove_plane->distance_mm = 1;
  EXPECT_EQ(good(points, params).counts[Rule::OnPlane], 3u);
  EXPECT_EQ(good(points, params).kept.size(), 8u);
  params.remove_plane->below = true;
  const Cleaned out = good(points, params);
  EXPECT_EQ(out.counts[Rule::BelowPlane], 4u);
  EXPECT_EQ(out.rows, (std::vector<std::uint64_t>{7, 8, 9, 10}));
}

TEST(CleanPoints, FindsTheDeckAndRemovesIt) {
  const DeckScene scene;
  Params params;
  params.remove_plane = PlaneRule{};
  params.remove_plane->fit = true;
  params.remove_plane->distance_mm = 0.3;
  params.remove_plane->below = true;
  const Cleaned out = good(scene.points, params);
  ASSERT_TRUE(out.rules && out.rules->plane);
  const FittedPlane& found = *out.rules->plane;
  EXPECT_GT(dot(found.plane.normal, scene.up), 1 - 1e-7);  // upwards: the box is there
  EXPECT_LT(std::abs(dot(found.plane.point - scene.at, scene.up)), 0.01);
  EXPECT_NEAR(found.share, 20.0 / 35, 0.02);
  EXPECT_NEAR(found.rms_mm, 0.05, 0.003);
  EXPECT_EQ(out.counts[Rule::OnPlane] + out.counts[Rule::BelowPlane], DeckScene::kDeck);
  EXPECT_EQ(out.kept.size(), DeckScene::kBox);
  EXPECT_EQ(out.rows.front(), DeckScene::kDeck);
}

TEST(CleanPoints, FitsThePlaneThatFacesAsTold) {
  // The box has faces of 1,500 to 2,250 mm2; the largest plane facing x is one of them, far smaller than the deck.
  const DeckScene scene;
  Params params;
  params.remove_plane = PlaneRule{};
  params.remove_plane->fit = true;
  params.remove_plane->distance_mm = 0.3;
  params.remove_plane->min_share = 0.05;
  params.remove_plane->max_tilt_deg = 20;
  const Vec3 side = perpendicular(scene.up);
  params.remove_plane->normal = side * -3;
  const Cleaned out = good(scene.points, params);
  ASSERT_TRUE(out.rules && out.rules->plane);
  EXPECT_LT(dot(out.rules->plane->plane.normal, side), -0.999);
}

TEST(CleanPoints, RefusesACloudWithoutAPlane) {
  const auto points = support::sphere_points({0, 0, 0}, 10, 5000, 1);
  Params params;
  params.remove_plane = PlaneRule{};
  params.remove_plane->fit = true;
  params.remove_plane->distance_mm = 0.1;
  const std::string text = failure(points, params);
  EXPECT_NE(text.find("no plane holds 20 % of the points within 0.1 mm; the best holds"), std::string::npos) << text;
  EXPECT_NE(failure({{0, 0, 0}, {1, 1, 1}}, params).find("only 2 points"), std::string::npos);
  EXPECT_NE(failure(std::vector<Vec3>(100, Vec3{1, 2, 3}), params).find("no plane"), std::string::npos);
}

/// A dense sphere of radius 10 with lone points and one small cluster about it.
struct SpeckScene {
  std::vector<Vec3> points;
  std::size_t sphere = 40000, lone = 25, cluster = 60;
  SpeckScene() {
    points = support::sphere_points({5, 5, 5}, 10, sphere, 2);
    for (std::size_t i = 0; i < lone; ++i)
      points.push_back({40 + 7 * double(i % 5), -30 + 7 * double(i / 5), 3.5 * double(i)});
    for (const Vec3& p : support::sphere_points({-20, 5, 5}, 1, cluster, 3)) points.push_back(p);
  }
};

TEST(CleanPoints, TakesLonePointsOutByDistance) {
  const SpeckScene scene;
  Params params;
  params.outliers = OutlierRules{};
  params.outliers->statistical = StatisticalRule{8, 3};
  const Cleaned out = good(scene.points, params);
  EXPECT_EQ(out.counts[Rule::Statistical], scene.lone);
  EXPECT_EQ(out.kept.size(), scene.sphere + scene.cluster);
  EXPECT_EQ(out.rules->outlier_report.statistical_points, scene.lone);
  EXPECT_EQ(out.rules->outlier_report.points, scene.points.size());
}

TEST(CleanPoints, TakesSmallPiecesOut) {
  const SpeckScene scene;
  Params params;
  params.outliers = OutlierRules{};
  params.outliers->min_component_points = 61;
  Cleaned out = good(scene.points, params);
  EXPECT_EQ(out.counts[Rule::Component], scene.lone + scene.cluster);
  EXPECT_EQ(out.rules->outlier_report.components, 1 + scene.lone + 1);
  EXPECT_EQ(out.rules->outlier_report.components_removed, scene.lone + 1);
  EXPECT_EQ(out.rules->outlier_report.largest_removed, scene.cluster);
  params.outliers->min_component_points = 60;
  EXPECT_EQ(good(scene.points, params).counts[Rule::Component], scene.lone);
  params.outliers->min_component_points.reset();
  params.outliers->min_component_share = 0.01;
  EXPECT_EQ(good(scene.points, params).counts[Rule::Component], scene.lone + scene.cluster);
  params.outliers->statistical = StatisticalRule{8, 3};
  out = good(scene.points, params);
  EXPECT_EQ(out.counts[Rule::Statistical], scene.lone);
  EXPECT_EQ(out.counts[Rule::Component], scene.cluster);
}

TEST(CleanPoints, JoinsPiecesWithinTheRange) {
  std::vector<Vec3> points;  // two rows of ten points, bins 0 .. 9 and 12 .. 21
  for (int i = 0; i < 10; ++i) points.push_back({i + 0.5, 0.5, 0.5}), points.push_back({i + 12.5, 0.5, 0.5});
  Params params;
  params.outliers = OutlierRules{};
  params.outliers->min_component_points = 11;
  params.outliers->component_range_bins = 2;
  EXPECT_EQ(good(points, params).kept.size(), 0u);
  params.outliers->component_range_bins = 3;
  EXPECT_EQ(good(points, params).kept.size(), 20u);
  params.outliers->component_range_bins = 1;
  params.outliers->bin_mm = 4;  // bins 0, 1, 2 and 3, 4, 5 touch
  EXPECT_EQ(good(points, params).kept.size(), 20u);
}

/// Pieces by brute force over points' bins.
std::vector<std::size_t> pieces_by_force(const std::vector<Vec3>& points, double h, int range) {
  std::vector<std::size_t> group(points.size());
  for (std::size_t i = 0; i < group.size(); ++i) group[i] = i;
  auto bin = [&](double c) { return std::floor(c / h); };
  for (bool changed = true; changed;) {
    changed = false;
    for (std::size_t i = 0; i < points.size(); ++i)
      for (std::size_t k = 0; k < i; ++k) {
        const Vec3 &a = points[i], &b = points[k];
        if (group[i] == group[k] || std::abs(bin(a.x) - bin(b.x)) > range || std::abs(bin(a.y) - bin(b.y)) > range ||
            std::abs(bin(a.z) - bin(b.z)) > range)
          continue;
        group[i] = group[k] = std::min(group[i], group[k]);
        changed = true;
      }
  }
  return group;
}

TEST(CleanPoints, AgreesWithBruteForceOnRandomClouds) {
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    Random random(9, seed, 0);
    std::vector<Vec3> points;
    for (int i = 0; i < 400; ++i)
      points.push_back({random.uniform(-15, 15), random.uniform(-15, 15), random.uniform(-15, 15)});
    const int range = 1 + static_cast<int>(seed % 3);
    Params params;
    params.outliers = OutlierRules{};
    params.outliers->component_range_bins = range;
    params.outliers->bin_mm = 1.25;
    params.outliers->min_component_points = 4;
    const auto group = pieces_by_force(points, 1.25, range);
    std::vector<std::uint64_t> wanted;
    for (std::size_t i = 0; i < points.size(); ++i)
      if (std::count(group.begin(), group.end(), group[i]) >= 4) wanted.push_back(i);
    EXPECT_EQ(good(points, params, 2, 64).rows, wanted) << "seed " << seed;

    params.outliers->min_component_points.reset();
    params.outliers->statistical = StatisticalRule{5, 1};
    std::vector<double> distance;
    double sum = 0, squares = 0;
    for (const Vec3& p : points) {
      double d = 1;
      for (; d <= 8; ++d) {
        int near = -1;
        for (const Vec3& q : points)
          near += std::abs(std::floor(p.x / 1.25) - std::floor(q.x / 1.25)) <= d &&
                  std::abs(std::floor(p.y / 1.25) - std::floor(q.y / 1.25)) <= d &&
                  std::abs(std::floor(p.z / 1.25) - std::floor(q.z / 1.25)) <= d;
        if (near >= 5) break;
      }
      distance.push_back(d);
      sum += d, squares += d * d;
    }
    const double mean = sum / 400, limit = mean + std::sqrt(squares / 400 - mean * mean);
    wanted.clear();
    for (std::size_t i = 0; i < points.size(); ++i)
      if (distance[i] <= std::max(limit, 1.0)) wanted.push_back(i);
    EXPECT_LT(wanted.size(), points.size());
    EXPECT_EQ(good(points, params, 2, 64).rows, wanted) << "seed " << seed;
  }
}

Params all_rules() {
  Params params;
  params.keep_box = Box{{-1000, -1000, -1000}, {1000, 1000, 345}};
  params.remove_box = {{{100, 200, 300}, {110, 210, 400}}};
  params.remove_plane = PlaneRule{};
  params.remove_plane->fit = true;
  params.remove_plane->distance_mm = 0.2;
  params.outliers = OutlierRules{};
  params.outliers->statistical = StatisticalRule{};
  params.outliers->min_component_points = 100;
  return params;
}

TEST(CleanPoints, IsTheSameForAnyThreadsAndBlocks) {
  std::vector<Vec3> points = DeckScene().points;
  for (const Vec3& p : SpeckScene().points) points.push_back(p + Vec3{100, 150, 310});
  const Params params = all_rules();
  const Cleaned one = good(points, params, 1, points.size());
  for (const Rule rule : {Rule::KeepBox, Rule::RemoveBox, Rule::OnPlane, Rule::Statistical, Rule::Component})
    EXPECT_GT(one.counts[rule], 0u) << name_of(rule);
  EXPECT_EQ(one.counts.removed() + one.kept.size(), points.size());
  EXPECT_EQ(one.sample.size(), 1000u);
  for (const int threads : {1, 2, 7})
    for (const std::size_t block : {777u, 65536u}) {
      const Cleaned other = good(points, params, threads, block);
      EXPECT_EQ(other.rows, one.rows);
      EXPECT_EQ(other.kept, one.kept);
      EXPECT_EQ(other.counts, one.counts);
      EXPECT_EQ(other.rules->plane->plane.normal, one.rules->plane->plane.normal);
      EXPECT_EQ(other.rules->plane->plane.point, one.rules->plane->plane.point);
      ASSERT_EQ(other.sample.size(), one.sample.size());
      for (std::size_t i = 0; i < one.sample.size(); ++i) {
        EXPECT_EQ(other.sample[i].source, one.sample[i].source);
        EXPECT_EQ(other.sample[i].rule, one.sample[i].rule);
      }
    }
}

TEST(CleanPoints, KeepsTheSamePointsInAnyOrder) {
  std::vector<Vec3> points = DeckScene().points;
  for (const Vec3& p : SpeckScene().points) points.push_back(p + Vec3{100, 150, 310});
  auto sorted = [](std::vector<Vec3> list) {
    std::sort(list.begin(), list.end(), [](Vec3 a, Vec3 b) { return before(a, b); });
    return list;
  };
  const Cleaned one = good(points, all_rules());
  Random random(5, 5, 5);
  for (std::size_t i = points.size(); i > 1; --i) std::swap(points[i - 1], points[random.next() % i]);
  const Cleaned other = good(points, all_rules());
  EXPECT_EQ(other.rules->plane->plane.point, one.rules->plane->plane.point);
  EXPECT_EQ(other.counts, one.counts);
  EXPECT_EQ(sorted(other.kept), sorted(one.kept));
}

TEST(CleanPoints, SampleIsCappedAndEvenlySpread) {
  std::vector<Vec3> points;
  for (int i = 0; i < 50000; ++i) points.push_back({double(i), 0, 0});
  Params params;
  params.keep_box = Box{{-1, -1, -1}, {1, 1, 1}};
  const Cleaned out = good(points, params, 2, 1000);
  ASSERT_EQ(out.sample.size(), 1000u);
  EXPECT_TRUE(std::is_sorted(out.sample.begin(), out.sample.end()));
  double mean = 0;
  for (const RemovedPoint& point : out.sample) {
    EXPECT_EQ(point.rule, Rule::KeepBox);
    EXPECT_EQ(point.position.x, static_cast<double>(point.source.row));
    mean += point.position.x / 1000;
  }
  EXPECT_NEAR(mean, 25000, 1500);
  const auto all = cleaned(MemoryPoints(points), params, 1, 1, 100000);
  ASSERT_TRUE(all.ok());
  EXPECT_EQ(all->sample.size(), 49999u);
}

/// Two views in turn, a block each.
class TwoViews final : public PointSource {
 public:
  std::size_t block_count() const override { return 6; }
  std::uint64_t expected_points() const override { return 60; }
  Result<void> read_block(std::size_t number, PointBlock& out) const override {
    if (number == failing) return fail(Code::BadInput, "broken", "block");
    out.clear();
    out.view = ViewId{static_cast<std::uint32_t>(number % 2)};
    for (std::uint64_t i = 0; i < 10; ++i) {
      out.positions.push_back({static_cast<double>(number), static_cast<double>(i), 0});
      out.rows.push_back(10 * number + i);
    }
    out.points_read = 12;
    out.not_finite = 2;
    return {};
  }
  std::size_t failing = 99;
};

TEST(CleanPoints, CountsByViewAndLeavesTheReadersCountsAlone) {
  Params params;
  params.keep_box = Box{{-1, 0, -1}, {4, 7, 1}};
  TwoViews points;
  const auto out = cleaned(points, params, 2);
  ASSERT_TRUE(out.ok());
  ASSERT_EQ(out->by_view.size(), 2u);
  EXPECT_EQ(out->by_view[0][Rule::KeepBox], 3u + 3 + 10);
  EXPECT_EQ(out->by_view[1][Rule::KeepBox], 3u + 3 + 10);
  EXPECT_EQ(out->counts[Rule::Kept], 28u);
  const CleanPoints clean(points, out->rules);
  PointBlock block;
  ASSERT_TRUE(clean.read_block(0, block).ok());
  EXPECT_EQ(block.points_read, 12u);
  EXPECT_EQ(block.not_finite, 2u);
  EXPECT_EQ(block.positions.size(), 7u);
  points.failing = 3;
  EXPECT_EQ(cleaned(points, params).error().text(), "block: broken");
  params.outliers = OutlierRules{};
  params.outliers->min_component_points = 2;
  EXPECT_EQ(cleaned(points, params, 2).error().text(), "block: broken");
}

TEST(CleanPoints, NamesEveryValueThatCannotBe) {
  Params params;
  params.keep_box = Box{{0, 0, 0}, {1, 0, 1}};
  params.remove_plane = PlaneRule{};
  params.outliers = OutlierRules{};
  const std::string text = failure({{0, 0, 0}}, params);
  for (const char* part :
       {"clean.keep_box: min must be below max", "clean.remove_plane.distance_mm",
        "clean.remove_plane: wanted fit: true, or point and normal", "clean.outliers: wanted at least"})
    EXPECT_NE(text.find(part), std::string::npos) << text;
  params = Params();
  params.outliers = OutlierRules{};
  params.outliers->min_component_points = 5;
  EXPECT_NE(failure({{0, 0, 0}}, params, 0).find("found no bin edge"), std::string::npos);
  EXPECT_NE(failure({{0, 0, 0}, {1e12, 0, 0}}, params).find("more than 2^30 bins"), std::string::npos);
  EXPECT_EQ(failure({}, params), "no error");
}

}  // namespace
}  // namespace scanmill::clean
