// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "oracle.hpp"

namespace scanmill::reduce {

void PrintTo(const SourceKey& key, std::ostream* out) { *out << "view " << index_of(key.view) << " row " << key.row; }
void PrintTo(Drop drop, std::ostream* out) { *out << "drop " << static_cast<int>(drop); }

namespace {

Reduction reduced(const PointSource& points, double bin_mm, const Params& params, int threads) {
  const ChunkLoop loop(threads);
  const CancelFlag cancel;
  LatticeParams lattice;
  lattice.bin_mm = bin_mm;
  auto result = reduce_cloud(points, lattice, params, {loop, cancel});
  if (!result.ok()) {
    ADD_FAILURE() << result.error().text();
    return {};
  }
  return std::move(result).value();
}

/// Frames from the oracle's moments, to give the oracle of the next step exact input.
Frames frames_from(const OracleBins& bins, const ReducedCloud& cloud, int radius) {
  BinCells cells;
  auto real = [](std::int64_t value) { return static_cast<double>(value); };
  for (const auto& [key, bin] : bins) {
    const Moments& m = bin.moments;
    Cell cell;
    cell.sums = {.xx = real(m.product[0]),
                 .yy = real(m.product[3]),
                 .zz = real(m.product[5]),
                 .count = real(m.count),
                 .xy = real(m.product[1]),
                 .yz = real(m.product[4]),
                 .xz = real(m.product[2]),
                 .z = real(m.sum[2]),
                 .x = real(m.sum[0]),
                 .y = real(m.sum[1])};
    cells.push_back(cell, {m.view_direction[0], m.view_direction[1], m.view_direction[2]});
  }
  const ChunkLoop loop(1);
  const CancelFlag cancel;
  const Context context{loop, cancel};
  return frames_of(cloud, cells, radius, context);
}

void expect_rows(const OracleBins& bins, const ReducedCloud& cloud) {
  ASSERT_EQ(cloud.size(), bins.size());
  for (const auto& [key, bin] : bins) {
    ASSERT_EQ(cloud.key(bin.row), key) << "row " << bin.row;  // Z-order too: the map is sorted by it
    ASSERT_EQ(cloud.counts[bin.row], std::ssize(bin.samples)) << "row " << bin.row;
  }
}

void expect_counts(const Reduction& reduction, const TestCloud& cloud) {
  const Report& report = reduction.report;
  std::uint64_t by_reason[5] = {};
  for (const Drop drop : reduction.cloud.drop) ++by_reason[static_cast<std::size_t>(drop)];
  EXPECT_EQ(report.kept, by_reason[0]);
  EXPECT_EQ(report.dropped_too_few, by_reason[1]);
  EXPECT_EQ(report.dropped_isolated, by_reason[2]);
  EXPECT_EQ(report.dropped_centre_distance, by_reason[3]);
  EXPECT_EQ(report.dropped_neighbour_distance, by_reason[4]);
  EXPECT_EQ(report.bins, reduction.cloud.size());
  EXPECT_EQ(report.points_read, cloud.samples.size());
  EXPECT_EQ(report.points_used, cloud.samples.size());
  Bounds bounds;
  for (const Sample& s : cloud.samples) bounds.add(s.position);
  EXPECT_EQ(report.bounds.low, bounds.low);
  EXPECT_EQ(report.bounds.high, bounds.high);
}

/// All of the result against the oracle: rows, representatives and their places of origin, frames, drops, counts.
void expect_oracle(const TestCloud& cloud, const Params& params, const Reduction& reduction) {
  const ReducedCloud& c = reduction.cloud;
  const OracleBins bins = oracle_bins(cloud, c.lattice);
  ASSERT_NO_FATAL_FAILURE(expect_rows(bins, c));
  const Frames frames = frames_from(bins, c, reduction.report.frame_radius);
  EXPECT_EQ(frames.median_residual, reduction.report.median_residual);
  const double crease_from = std::max(2.5 * frames.median_residual, 0.2);
  for (const auto& [key, bin] : bins) {
    const std::size_t row = bin.row;
    SCOPED_TRACE("row " + std::to_string(row));
    const Vec3 n = frames.normal[row], centroid = frames.centroid[row], centre = centre_of(c.lattice, key);
    ASSERT_EQ(c.normal[row], n);  // equal only when the integer moments are
    ASSERT_EQ(c.residual[row], frames.residual[row]);
    const bool crease = params.edge_aware && frames.residual[row] > crease_from;
    const Vec3 foot = crease ? centroid : centre - n * dot(centre - centroid, n);
    const Sample kept = params.representative == Representative::Centre ? nearest_to_centre(bin, c.lattice)
                                                                        : nearest_to_foot(bin, foot, n, crease);
    ASSERT_EQ(c.source[row], kept.source);
    ASSERT_EQ(c.measured[row], kept.position);
    const double off = dot(kept.position - centroid, n);
    const bool projects = frames.valid[row] && std::abs(off) < 1.5 * c.lattice.edge_mm;
    ASSERT_EQ(c.projected[row], projects ? kept.position - n * off : kept.position);
  }
  ASSERT_EQ(c.drop, oracle_drops(c, bins, params));
  expect_counts(reduction, cloud);
}

std::vector<std::pair<std::string, Params>> rules() {
  Params scan, c1 = Params::paper(), few, creases;
  c1.max_centre_distance = 0.35;
  c1.min_neighbour_distance = 0.8;
  few.min_points_per_bin = 3;
  few.representative = Representative::Centre;
  few.min_neighbour_distance.reset();
  creases.edge_aware = true;
  creases.neighbour_positions = NeighbourPositions::Measured;
  return {{"scan", scan}, {"paper", Params::paper()}, {"c1 and c2", c1}, {"at least 3, no c2", few}, {"edge", creases}};
}

TEST(ReduceCloud, EqualsTheBruteForceOracle) {
  for (const TestCloud& cloud : clouds::all(100))
    for (const auto& [name, params] : rules()) {
      SCOPED_TRACE(cloud.name + ", " + name);
      ASSERT_NO_FATAL_FAILURE(expect_oracle(cloud, params, reduced(in_order(cloud, 512), cloud.bin_mm, params, 1)));
    }
}

TEST(ReduceCloud, IsTheSameForAnyThreadsBlocksAndOrderOfBlocks) {
  for (const TestCloud& cloud : clouds::all(200))
    for (const auto& [name, params] : rules())
      for (const int threads : {1, 2, 7}) {
        SCOPED_TRACE(cloud.name + ", " + name + ", threads " + std::to_string(threads));
        const auto reduction =
            reduced(dealt(cloud, 5 + static_cast<std::uint64_t>(threads), 11), cloud.bin_mm, params, threads);
        ASSERT_NO_FATAL_FAILURE(expect_oracle(cloud, params, reduction));
      }
}

/// Rows of a file in another order: the same points at other row numbers.
TEST(ReduceCloud, RenumbersNothingButRowsWhenRowsAreShuffled) {
  TestCloud cloud = clouds::torus(7), shuffled = cloud;
  Random random(3, 3, 3);
  const std::size_t half = cloud.samples.size() / 2;
  for (std::size_t i = half; i > 1; --i)
    std::swap(shuffled.samples[i - 1].position, shuffled.samples[random.next() % i].position);
  const auto a = reduced(in_order(cloud, 512), cloud.bin_mm, {}, 1),
             b = reduced(in_order(shuffled, 99), cloud.bin_mm, {}, 2);
  EXPECT_EQ(a.cloud.measured, b.cloud.measured);
  EXPECT_EQ(a.cloud.normal, b.cloud.normal);
  EXPECT_EQ(a.cloud.drop, b.cloud.drop);
  EXPECT_NE(a.cloud.source, b.cloud.source);
  for (std::size_t row = 0; row < b.cloud.size(); ++row) {
    const SourceKey from = b.cloud.source[row];
    const std::size_t at = index_of(from.view) == 0 ? from.row : from.row - 5 + half;
    ASSERT_EQ(shuffled.samples[at].position, b.cloud.measured[row]);
  }
}

TEST(Frames, AreThePlanesOfTheWeightedMoments) {
  int compared = 0;
  for (const TestCloud& cloud : clouds::all(300)) {
    SCOPED_TRACE(cloud.name);
    const auto reduction = reduced(in_order(cloud, 512), cloud.bin_mm, {}, 1);
    const ReducedCloud& c = reduction.cloud;
    const OracleBins bins = oracle_bins(cloud, c.lattice);
    ASSERT_EQ(bins.size(), c.size());
    for (const auto& [key, bin] : bins) {
      const OraclePlane plane = oracle_plane(bins, c.lattice, key, reduction.report.frame_radius);
      EXPECT_EQ(c.frame_valid[bin.row], plane.bins >= 4 && plane.trace > 0.05);
      EXPECT_NEAR(c.residual[bin.row], std::sqrt(plane.least), 1e-6);
      EXPECT_NEAR(norm(c.normal[bin.row]), 1, 1e-14);
      if (plane.gap < 1e-3 * plane.trace) continue;  // the normal is not determined
      EXPECT_NEAR(std::abs(dot(c.normal[bin.row], plane.normal)), 1, 1e-14);
      EXPECT_LT(norm(cross(c.normal[bin.row], plane.normal)), 1e-9) << "row " << bin.row;
      const double off = dot(centre_of(c.lattice, key) - plane.centroid, plane.normal) / c.lattice.edge_mm;
      EXPECT_NEAR(c.plane_distance[bin.row], std::abs(off), cloud.name == "sphere, far away" ? 1e-5 : 1e-6);
      ++compared;
    }
  }
  EXPECT_GT(compared, 3000);
}

/// Seen from one place: normals turn to the eye, and only where the eye is not level with the surface.
TEST(Frames, TurnToTheEyeThatSawThem) {
  TestCloud cloud = clouds::sphere(11);
  const Vec3 eye{0, 0, 500};
  cloud.views = {ViewPoint{eye, std::nullopt}, ViewPoint{eye, std::nullopt}};
  const auto reduction = reduced(in_order(cloud, 512), cloud.bin_mm, {}, 1);
  int known = 0;
  for (std::size_t row = 0; row < reduction.cloud.size(); ++row) {
    const Vec3 to_eye = unit(eye - reduction.cloud.measured[row]);
    if (!reduction.cloud.sign_known[row]) continue;
    ++known;
    EXPECT_GT(dot(reduction.cloud.normal[row], to_eye), 0) << "row " << row;
  }
  EXPECT_GT(known, static_cast<int>(reduction.cloud.size()) / 2);
  EXPECT_LT(known, static_cast<int>(reduction.cloud.size()));
}

}  // namespace
}  // namespace scanmill::reduce
