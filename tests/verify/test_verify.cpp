// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "cloud/piece.hpp"
#include "verify/meshes.hpp"
#include "verify/triangle_index.hpp"
#include "verify/verify.hpp"

namespace scanmill::verify {
namespace {

Report judged(const Mesh& mesh, const PointSource& points, const Terms& terms = {}, int threads = 1,
              const Params& params = {}) {
  const Workers workers(threads);
  auto report = verify_mesh(mesh, points, terms, params, workers.context());
  EXPECT_TRUE(report.ok()) << (report.ok() ? "" : report.error().text());
  return report.ok() ? std::move(*report) : Report{};
}

std::vector<Vec3> points_about(const Mesh& mesh, std::size_t count, std::uint64_t seed) {
  Random random(seed, 5, 5);
  std::vector<Vec3> points;
  for (std::size_t n = 0; n < count; ++n) {
    const Triangle& t = mesh.triangles[random.next() % mesh.triangles.size()];
    const double off = n % 10 == 0 ? 3 : 0.1;
    points.push_back(mesh.positions[t[n % 3]] + Vec3{random.gauss() * off, random.gauss() * off, random.gauss() * off} +
                     mesh.offset);
  }
  return points;
}

/// Blocks of another source in another order and size, with views and rows that stay.
class Shuffled final : public PointSource {
 public:
  Shuffled(std::vector<Vec3> points, std::size_t block, std::uint64_t seed)
      : points_(std::move(points)), block_(block) {
    order_.resize((points_.size() + block - 1) / block);
    std::iota(order_.begin(), order_.end(), std::size_t{0});
    Random random(seed, 0, 0);
    for (std::size_t n = order_.size(); n > 1; --n) std::swap(order_[n - 1], order_[random.next() % n]);
  }
  std::size_t block_count() const override { return order_.size(); }
  Result<void> read_block(std::size_t number, PointBlock& out) const override {
    out.clear();
    out.view = ViewId{3};
    for (std::size_t n = order_[number] * block_; n < std::min(points_.size(), (order_[number] + 1) * block_); ++n) {
      out.positions.push_back(points_[n]);
      out.rows.push_back(n + 100);
    }
    out.points_read = out.positions.size() + 2;
    out.not_finite = 2;
    return {};
  }
  std::uint64_t expected_points() const override { return points_.size(); }

 private:
  std::vector<Vec3> points_;
  std::size_t block_;
  std::vector<std::size_t> order_;
};

TEST(VerifyMesh, AgreesWithMeasuringEveryTriangle) {
  const Mesh mesh = sheet(12, 0.7, [](double x, double y) { return std::abs(x - 4) - 0.3 * y; });
  const auto points = points_about(mesh, 3000, 1);
  Terms terms;
  terms.bin_mm = 0.7;
  const Report report = judged(mesh, MemoryPoints(points, {}, 500), terms);
  std::vector<double> distances;
  for (const Vec3 p : points) {
    double best = 1e300;
    for (const auto& [a, b, c] : mesh.triangles)
      best = std::min(best, closest_on_triangle(p, mesh.positions[a], mesh.positions[b], mesh.positions[c]).distance2);
    distances.push_back(std::sqrt(best));
  }
  std::sort(distances.begin(), distances.end());
  double sum = 0, sum2 = 0;
  for (const double d : distances) {
    sum += d;
    sum2 += d * d;
  }
  const auto near = [&](double found, double wanted) { EXPECT_NEAR(found, wanted, 4e-6 * 0.7 + 1e-6 * wanted); };
  EXPECT_EQ(report.all.count, 3000u);
  EXPECT_EQ(report.all.max_mm, distances.back());
  EXPECT_EQ(std::max(report.all.above_mm, report.all.below_mm), distances.back());
  near(report.all.mean_mm, sum / 3000);
  near(report.all.rms_mm, std::sqrt(sum2 / 3000));
  const auto rank = [&](double q) { return distances[static_cast<std::size_t>(q * 2999)]; };
  near(report.all.percentiles->p50, rank(0.5));
  near(report.all.percentiles->p90, rank(0.9));
  near(report.all.percentiles->p95, rank(0.95));
  near(report.all.percentiles->p99, rank(0.99));
  near(report.all.percentiles->p999, rank(0.999));
  EXPECT_EQ(report.interior.count + report.open_border.count, 3000u);
  ASSERT_EQ(report.worst.size(), 10u);
  for (std::size_t n = 0; n < 10; ++n) EXPECT_EQ(report.worst[n].distance_mm, distances[2999 - n]);
}

TEST(VerifyMesh, PercentilesHoldFarFromTheMeshToo) {
  const Mesh mesh = flat_sheet(2, 1);
  Random random(1, 1, 1);
  std::vector<Vec3> points;
  std::vector<double> heights;
  for (int n = 0; n < 2001; ++n) {
    double scale = 1e-6;  // from a millionth to a million bin edges
    for (int k = 0; k < n % 12; ++k) scale *= 10;
    heights.push_back(scale * random.uniform(1, 10));
    points.push_back({1, 0.5, heights.back()});
  }
  const Report report = judged(mesh, MemoryPoints(points));
  std::sort(heights.begin(), heights.end());
  EXPECT_NEAR(report.all.percentiles->p50, heights[1000], 4e-6 + 1e-6 * heights[1000]);
  EXPECT_NEAR(report.all.percentiles->p90, heights[1800], 4e-6 + 1e-6 * heights[1800]);
  EXPECT_EQ(report.all.max_mm, heights.back());
}

TEST(VerifyMesh, SignsByTheNormalAlsoPastSharpEdges) {
  const Mesh mesh = cube(2);
  Random random(8, 8, 8);
  std::vector<Vec3> outside, inside;
  for (int n = 0; n < 4000; ++n) {
    const Vec3 p{random.uniform(-1, 3), random.uniform(-1, 3), random.uniform(-1, 3)};
    const bool in = std::min({p.x, p.y, p.z}) > 0 && std::max({p.x, p.y, p.z}) < 2;
    (in ? inside : outside).push_back(p);
  }
  const Report out = judged(mesh, MemoryPoints(outside)), in = judged(mesh, MemoryPoints(inside));
  EXPECT_EQ(out.all.below_mm, 0);
  EXPECT_EQ(in.all.above_mm, 0);
  EXPECT_NEAR(out.all.signed_mean_mm, out.all.mean_mm, 1e-12);
  EXPECT_NEAR(in.all.signed_mean_mm, -in.all.mean_mm, 1e-12);
}

TEST(VerifyMesh, StatesTheOpenBorderApart) {
  const Mesh mesh = flat_sheet(4, 1);
  const Report report = judged(mesh, MemoryPoints({{2, 2.1, 0.25}, {1.3, 1, -0.5}, {5, 2, 0}, {-2, -2, 0}}));
  EXPECT_EQ(report.interior.count, 2u);
  EXPECT_EQ(report.interior.max_mm, 0.5);
  EXPECT_EQ(report.interior.below_mm, 0.5);
  EXPECT_EQ(report.interior.above_mm, 0.25);
  EXPECT_EQ(report.open_border.count, 2u);
  EXPECT_EQ(report.open_border.max_mm, std::sqrt(8.0));
  ASSERT_EQ(report.worst.size(), 4u);
  EXPECT_TRUE(report.worst[0].open_border && report.worst[1].open_border);
  ASSERT_EQ(report.worst_interior.size(), 2u);
  EXPECT_EQ(report.worst_interior[0].signed_mm, -0.5);
  EXPECT_EQ(report.worst_interior[0].place, (Vec3{1.3, 1, -0.5}));
  EXPECT_EQ(report.worst_interior[0].source.row, 1u);
}

TEST(VerifyMesh, StatesPatchesAndTheirBordersApart) {
  Mesh mesh = flat_sheet(4, 1);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) mesh.patch[t] = t < 8 ? 0 : 2;  // first row of squares
  const std::vector<std::string> names{"base", "none", "rest"};
  Terms terms;
  terms.patch_names = names;
  const Report report = judged(mesh, MemoryPoints({{2, 0.5, 0.25}, {2, 1.4, -0.125}, {2, 3.5, 1}}), terms);
  ASSERT_EQ(report.patches.size(), 2u);
  EXPECT_EQ(report.patches[0].name, "base");
  EXPECT_EQ(report.patches[0].triangles, 8u);
  EXPECT_EQ(report.patches[0].distances.max_mm, 0.25);
  EXPECT_EQ(report.patches[1].patch, 2u);
  EXPECT_EQ(report.patches[1].distances.count, 2u);
  EXPECT_EQ(report.patches[1].distances.max_mm, 1);
  EXPECT_EQ(report.patch_borders.count, 2u);  // beside y = 1; the third lies a row away
  EXPECT_EQ(report.patch_borders.max_mm, 0.25);
}

TEST(VerifyMesh, GivesVerticesTheErrorOfTheirOwnBin) {
  const Mesh mesh = flat_sheet(1, 2);  // corners (0,0) (2,0) (0,2) (2,2)
  // Bins of edge 1: the vertices' own, and one in the middle with no vertex.
  const std::vector<LocalBin> bins{{0, 0, 0}, {1, 1, 0}, {2, 0, 0}, {0, 2, 0}, {2, 2, 0}};
  const BinIndex index = BinIndex::over(bins);
  BinIndex::Reader reader(index);
  std::vector<std::uint32_t> vertex_of_row(bins.size(), kNoVertex);
  for (std::uint32_t v = 0; v < 4; ++v) {
    const Vec3 p = mesh.positions[v];
    vertex_of_row[static_cast<std::size_t>(
        reader.row_at({static_cast<std::int32_t>(p.x), static_cast<std::int32_t>(p.y), 0}))] = v;
  }
  Terms terms;
  terms.vertex_bins = VertexBins{Lattice{1, {10, 20, 30}}, {0, 0, 0}, &index, vertex_of_row};
  Mesh placed = mesh;
  placed.offset = {10, 20, 30};
  // Mesh frame: bin (0,0,0) twice, the middle once, (2,2,0) once; one in no bin.
  const Vec3 at = placed.offset;
  const Report report = judged(placed,
                               MemoryPoints({at + Vec3{0.5, 0.5, 0.25}, at + Vec3{0.5, 0.25, 0.5},
                                             at + Vec3{1.5, 1.5, 0.75}, at + Vec3{2.25, 2, 0}, at + Vec3{-7, 0, 0}}),
                               terms);
  ASSERT_EQ(report.vertices.size(), 4u);
  EXPECT_EQ(report.vertices[0].points, 2u);
  EXPECT_EQ(report.vertices[0].signed_mm, 0.5);
  EXPECT_NEAR(report.vertices[0].rms_mm, std::sqrt((0.0625 + 0.25) / 2), 1e-6);
  EXPECT_EQ(report.vertices[1].points, 0u);
  EXPECT_EQ(report.vertices[1].signed_mm, 0);
  EXPECT_EQ(report.vertices[3].points, 1u);
  EXPECT_EQ(std::abs(report.vertices[3].signed_mm), 0.25);
  EXPECT_EQ(report.coverage.bins, 5u);
  EXPECT_EQ(report.coverage.bins_near, 3u);
}

TEST(VerifyMesh, CountsTrianglesThatPointsLieNear) {
  const Mesh mesh = flat_sheet(2, 1);
  const Report report = judged(mesh, MemoryPoints({{0.7, 0.2, 0.1}, {0.2, 0.7, 0.1}, {1.7, 1.2, 5}}));
  EXPECT_EQ(report.coverage.triangles, 8u);
  EXPECT_EQ(report.coverage.triangles_near, 2u);
}

TEST(VerifyMesh, CountsBySignedDistance) {
  const Mesh mesh = flat_sheet(2, 1);
  const Report report = judged(
      mesh, MemoryPoints({{1, 0.5, 0}, {1, 0.5, 0.03}, {1, 0.5, -0.01}, {1, 0.5, 1.99}, {1, 0.5, 2}, {1, 0.5, -3}}));
  EXPECT_EQ(report.histogram.counts[64], 2u);
  EXPECT_EQ(report.histogram.counts[63], 1u);
  EXPECT_EQ(report.histogram.counts[127], 1u);
  EXPECT_EQ(report.histogram.above, 1u);
  EXPECT_EQ(report.histogram.below, 1u);
  EXPECT_EQ(report.histogram.step_mm, 1.0 / 32);
}

TEST(VerifyMesh, GatesTellWhatWasFound) {
  const Mesh mesh = flat_sheet(2, 1);
  const MemoryPoints points({{1, 0.5, 0.25}, {1, 0.5, -0.25}});
  Params params;
  EXPECT_TRUE(judged(mesh, points).gates.empty());
  params.max_error_mm = 0.25;
  params.rms_mm = 0.2;
  const Report report = judged(mesh, points, {}, 1, params);
  ASSERT_EQ(report.gates.size(), 2u);
  EXPECT_TRUE(report.gates[0].passed);
  EXPECT_EQ(report.gates[1].name, "rms_mm");
  EXPECT_NEAR(report.gates[1].found, 0.25, 1e-6);
  EXPECT_FALSE(report.gates[1].passed);
  EXPECT_FALSE(report.passed());
  EXPECT_EQ(report.fit_error_mm, 0.25);
  EXPECT_EQ(report.total_error_mm, 0.25 + kPaperAccuracy);
}

void expect_same(const DistanceFigures& a, const DistanceFigures& b) {
  EXPECT_EQ(a.count, b.count);
  EXPECT_EQ(a.max_mm, b.max_mm);
  EXPECT_EQ(a.rms_mm, b.rms_mm);
  EXPECT_EQ(a.mean_mm, b.mean_mm);
  EXPECT_EQ(a.signed_mean_mm, b.signed_mean_mm);
  EXPECT_EQ(a.above_mm, b.above_mm);
  ASSERT_EQ(a.percentiles.has_value(), b.percentiles.has_value());
  if (a.percentiles) {
    EXPECT_EQ(a.percentiles->p50, b.percentiles->p50);
    EXPECT_EQ(a.percentiles->p999, b.percentiles->p999);
  }
}

void expect_same(const Report& many, const Report& one) {
  expect_same(many.all, one.all);
  expect_same(many.interior, one.interior);
  expect_same(many.open_border, one.open_border);
  expect_same(many.patch_borders, one.patch_borders);
  ASSERT_EQ(many.patches.size(), one.patches.size());
  for (std::size_t n = 0; n < one.patches.size(); ++n) expect_same(many.patches[n].distances, one.patches[n].distances);
  EXPECT_EQ(many.histogram.counts, one.histogram.counts);
  EXPECT_EQ(many.coverage.triangles_near, one.coverage.triangles_near);
  EXPECT_EQ(many.coverage.bins_near, one.coverage.bins_near);
  ASSERT_EQ(many.worst.size(), one.worst.size());
  for (std::size_t n = 0; n < one.worst.size(); ++n) {
    EXPECT_EQ(many.worst[n].source, one.worst[n].source);
    EXPECT_EQ(many.worst[n].signed_mm, one.worst[n].signed_mm);
    EXPECT_EQ(many.worst[n].triangle, one.worst[n].triangle);
  }
  ASSERT_EQ(many.vertices.size(), one.vertices.size());
  for (std::size_t v = 0; v < one.vertices.size(); ++v) {
    EXPECT_EQ(many.vertices[v].signed_mm, one.vertices[v].signed_mm);
    EXPECT_EQ(many.vertices[v].rms_mm, one.vertices[v].rms_mm);
    EXPECT_EQ(many.vertices[v].points, one.vertices[v].points);
  }
}

/// A bent sheet of several patches, 20,000 points about it, and bins behind its first vertices.
struct BentSheet {
  BentSheet() {
    mesh = sheet(25, 0.5, [](double x, double y) { return 0.2 * x * std::abs(y - 5); });
    for (std::size_t t = 0; t < mesh.patch.size(); ++t) mesh.patch[t] = static_cast<std::uint32_t>(t / 300);
    points = points_about(mesh, 20000, 4);
    std::vector<LocalBin> bins;
    for (std::int32_t n = 0; n < 512; ++n) {
      bins.push_back({n % 8, n / 8 % 8, n / 64});
      vertex_of_row.push_back(static_cast<std::uint32_t>(n));
    }
    std::sort(bins.begin(), bins.end(), [](const LocalBin& a, const LocalBin& b) {
      return before(BinKey{a[0], a[1], a[2]}, BinKey{b[0], b[1], b[2]});
    });
    index = BinIndex::over(bins);
    terms.bin_mm = 0.5;
    terms.vertex_bins = VertexBins{Lattice{0.5, {}}, {}, &index, vertex_of_row};
  }
  BentSheet(const BentSheet&) = delete;
  Mesh mesh;
  decltype(points_about(mesh, 1, 1)) points;
  std::vector<std::uint32_t> vertex_of_row;
  BinIndex index;
  Terms terms;
};

TEST(VerifyMesh, DoesNotDependOnThreadsOrTheOrderOfBlocks) {
  const BentSheet s;
  const Report one = judged(s.mesh, Shuffled(s.points, 20000, 1), s.terms);
  EXPECT_EQ(one.points_read, 20002u);
  EXPECT_EQ(one.not_finite, 2u);
  for (const int threads : {1, 2, 7})
    for (const std::size_t block : {64, 1000})
      expect_same(judged(s.mesh, Shuffled(s.points, block, block), s.terms, threads), one);
}

TEST(VerifyPiece, AddsUpToTheWhole) {
  const BentSheet s;
  const Shuffled all(s.points, 64, 1);
  const Report one = judged(s.mesh, all, s.terms);
  const ChunkLoop loop(3);
  const CancelFlag cancel;
  const Params params;
  for (const std::uint32_t pieces : {1u, 3u, 700u}) {  // more than there are blocks: some hold nothing
    auto verdicts = PieceVerdicts::of(s.mesh, s.terms, params);
    ASSERT_TRUE(verdicts.ok());
    for (std::uint32_t n = pieces; n-- > 0;) {
      const auto piece = verify_piece(s.mesh, PiecePoints(all, n, pieces), s.terms, params, {loop, cancel});
      ASSERT_TRUE(piece.ok());
      ASSERT_TRUE(verdicts->add(*piece).ok());
    }
    const auto report = (*std::move(verdicts)).report();
    ASSERT_TRUE(report.ok());
    expect_same(*report, one);
  }
}

TEST(VerifyPiece, IsRefusedWhenCutOrOfAnotherMesh) {
  const BentSheet s;
  const ChunkLoop loop(1);
  const CancelFlag cancel;
  const Params params;
  const auto piece = verify_piece(s.mesh, Shuffled(s.points, 64, 1), s.terms, params, {loop, cancel});
  ASSERT_TRUE(piece.ok());
  auto is_refused = [&](const Mesh& mesh, const PieceVerdict& verdict) {
    auto verdicts = PieceVerdicts::of(mesh, s.terms, params);
    return verdicts.ok() && !verdicts->add(verdict).ok();
  };
  EXPECT_FALSE(is_refused(s.mesh, *piece));
  for (const std::size_t size : {std::size_t{0}, std::size_t{31}, piece->seen.size() / 2, piece->seen.size() - 1}) {
    PieceVerdict cut = *piece;
    cut.seen.resize(size);
    EXPECT_TRUE(is_refused(s.mesh, cut)) << size;
  }
  PieceVerdict far = *piece;
  far.vertices.back().vertex = s.mesh.positions.size();
  EXPECT_TRUE(is_refused(s.mesh, far));
  Mesh less = s.mesh;
  less.triangles.pop_back();
  less.patch.pop_back();
  EXPECT_TRUE(is_refused(less, *piece));
}

TEST(VerifyMesh, TakesAnyMesh) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const Mesh mesh = soup(200, seed);
    const auto points = points_about(mesh, 500, seed);
    const Report report = judged(mesh, MemoryPoints(points));
    EXPECT_EQ(report.all.count, 500u);
    EXPECT_TRUE(std::isfinite(report.all.rms_mm) && std::isfinite(report.all.signed_mean_mm));
  }
}

TEST(VerifyMesh, SaysWhatIsMissing) {
  const Workers workers;
  auto error_of = [&](const Mesh& mesh, std::vector<Vec3> points, const Terms& terms = {}, const Params& params = {}) {
    const auto report = verify_mesh(mesh, MemoryPoints(std::move(points)), terms, params, workers.context());
    EXPECT_FALSE(report.ok());
    return report.ok() ? std::string() : report.error().text();
  };
  EXPECT_NE(error_of(Mesh{}, {{0, 0, 0}}).find("no triangle"), std::string::npos);
  Mesh line;
  line.positions = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  line.triangles = {{0, 1, 2}};
  EXPECT_NE(error_of(line, {{0, 0, 0}}).find("area"), std::string::npos);
  EXPECT_NE(error_of(cube(), {}).find("no finite point"), std::string::npos);
  EXPECT_NE(error_of(cube(), {{0, 0, 0}, {0, 1e200, 0}}).find("row 1"), std::string::npos);
  Terms terms;
  terms.bin_mm = 0;
  EXPECT_NE(error_of(cube(), {{0, 0, 0}}, terms).find("bin edge"), std::string::npos);
  Params params;
  params.rms_mm = -1;
  EXPECT_NE(error_of(cube(), {{0, 0, 0}}, {}, params).find("rms_mm"), std::string::npos);
  Mesh patches = cube();
  patches.patch[3] = 4000000000u;
  EXPECT_NE(error_of(patches, {{0, 0, 0}}).find("patch"), std::string::npos);
}

}  // namespace
}  // namespace scanmill::verify
