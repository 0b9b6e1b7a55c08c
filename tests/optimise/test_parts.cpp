// SPDX-License-Identifier: Apache-2.0
// A mesh swapped part by part is the mesh swapped whole, or it is told that it is not.
#include <gtest/gtest.h>

#include <cmath>

#include "meshes.hpp"
#include "optimise/parts.hpp"

namespace scanmill::optimise {
namespace {

constexpr double kBin = 0.4;

std::int32_t whole_below(double x) { return static_cast<std::int32_t>(std::floor(x)); }

Block place_of(Vec3 p, double edge) {
  return {whole_below(p.x / edge), whole_below(p.y / edge), whole_below(p.z / edge)};
}

/// The vertices of one brick and those at most `halo` bins from it.
Part part_of(const Mesh& mesh, const Block& brick, std::int32_t brick_bins, std::int32_t halo) {
  Part part;
  part.reach_mm = halo * kBin;
  part.block_mm = kBlockBins * kBin;
  part.mesh.offset = mesh.offset;
  std::vector<std::uint32_t> here(mesh.positions.size(), 0);
  for (std::uint32_t v = 0; v < mesh.positions.size(); ++v) {
    const Block bin = place_of(mesh.positions[v], kBin);
    std::int32_t away = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int32_t low = brick[k] * brick_bins, high = low + brick_bins - 1;
      away = std::max({away, low - bin[k], bin[k] - high});
    }
    if (away > halo) continue;
    part.mesh.positions.push_back(mesh.positions[v]);
    part.vertex.push_back(v);
    part.own.push_back(away <= 0);
    part.block.push_back(place_of(mesh.positions[v], kBlockBins * kBin));
    here[v] = static_cast<std::uint32_t>(part.vertex.size());
  }
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    Triangle v = mesh.triangles[t];
    if (!here[v[0]] || !here[v[1]] || !here[v[2]]) continue;
    for (std::uint32_t& corner : v) corner = here[corner] - 1;
    part.mesh.triangles.push_back(v);
    part.mesh.patch.push_back(mesh.patch[t]);
  }
  return part;
}

struct InParts {
  Mesh mesh;
  Report report;
  bool is_sure = true, do_agree = false;
  std::size_t parts = 0;
};

InParts swap_in_parts(const Mesh& mesh, const Params& params, const Limits& limits, std::int32_t brick_bins,
                      std::int32_t halo) {
  const support::Workers workers(2);
  std::vector<Block> bricks;
  for (const Vec3 p : mesh.positions) bricks.push_back(place_of(p, brick_bins * kBin));
  std::sort(bricks.begin(), bricks.end());
  bricks.erase(std::unique(bricks.begin(), bricks.end()), bricks.end());
  InParts all{mesh, {}, true, false, bricks.size()};
  all.mesh.triangles.clear();
  all.mesh.patch.clear();
  std::vector<Account> accounts;
  std::vector<std::pair<Triangle, std::uint32_t>> faces;
  PartReports reports;
  for (const Block& brick : bricks) {
    auto swapped = optimise_part(part_of(mesh, brick, brick_bins, halo), params, limits, workers.context());
    EXPECT_TRUE(swapped.ok());
    if (!swapped.ok()) return all;
    for (std::size_t n = 0; n < swapped->triangles.size(); ++n)
      faces.emplace_back(swapped->triangles[n], swapped->patch[n]);
    reports.add(swapped->tally, swapped->rounds, swapped->between);
    all.is_sure = all.is_sure && swapped->tally.is_sure;
    accounts.push_back(
        {std::move(swapped->events), std::move(swapped->own), std::move(swapped->watched), swapped->tally.turns, true});
  }
  std::sort(faces.begin(), faces.end());
  for (const auto& [corners, patch] : faces) {
    all.mesh.triangles.push_back(corners);
    all.mesh.patch.push_back(patch);
  }
  all.do_agree = agree(accounts);
  const auto report = reports.report(mesh.triangles, all.mesh, params, limits, workers.context());
  all.report = report;
  return all;
}

std::vector<double> numbers(const PassReport& p) {
  const Refused& r = p.refused;
  std::vector<double> list{static_cast<double>(p.done), p.angle_p5_before_deg, p.angle_p5_after_deg, p.longest_edge_mm};
  for (const std::uint64_t n :
       {p.rounds, p.swaps, r.patch_border, r.not_convex, r.range, r.angle, r.fold, r.edge_exists, r.crossing})
    list.push_back(static_cast<double>(n));
  return list;
}
std::vector<double> numbers(const Creases& c) {
  return {static_cast<double>(c.inner_edges), c.dihedral_sum_deg, static_cast<double>(c.sharp_edges), c.sharp_length_mm,
          c.normal_variation_rms};
}

void expect_same(const Report& a, const Report& b) {
  EXPECT_EQ(numbers(a.smooth), numbers(b.smooth));
  EXPECT_EQ(numbers(a.feature), numbers(b.feature));
  EXPECT_EQ(numbers(a.before_feature), numbers(b.before_feature));
  EXPECT_EQ(numbers(a.after_feature), numbers(b.after_feature));
}

Mesh start_of(const std::string& shape, double noise) {
  Mesh mesh = mesh_of(shape, kBin, noise);
  shuffle_diagonals(mesh, 2.5 * kBin, mesh.triangles.size(), 9);
  return mesh;
}

void expect_whole(const Mesh& start, const Params& params, std::int32_t brick_bins) {
  const Limits limits = limits_of(2.5 * kBin);
  Mesh whole = start;
  const auto report = run(whole, params, limits);
  ASSERT_TRUE(report.ok());
  EXPECT_GT(report->smooth.swaps + report->feature.swaps, 0u);
  const InParts parts = swap_in_parts(start, params, limits, brick_bins, 24);
  EXPECT_GT(parts.parts, 1u);
  EXPECT_TRUE(parts.is_sure && parts.do_agree);
  EXPECT_TRUE(parts.mesh.triangles == whole.triangles && parts.mesh.patch == whole.patch);
  expect_same(parts.report, *report);
}

TEST(Parts, GiveTheMeshAndTheReportOfTheWhole) {
  for (const char* shape : {"torus", "wavy sheet with a hole", "thin plate", "touching spheres"}) {
    SCOPED_TRACE(shape);
    expect_whole(start_of(shape, 0), {}, 32);
  }
  const Mesh box = start_of("box", 0.05);
  for (const Params params : {Params{true, true}, Params{false, true}, Params{true, false}})
    expect_whole(box, params, 16);
}

TEST(Parts, TellWhenTheySawTooLittle) {
  const Mesh start = start_of("box", 0.05);
  const Limits limits = limits_of(2.5 * kBin);
  Mesh whole = start;
  ASSERT_TRUE(run(whole, {}, limits).ok());
  int wrong = 0, right = 0;
  for (const std::int32_t halo : {1, 2, 4, 8, 10, 12, 20}) {
    const InParts parts = swap_in_parts(start, {}, limits, 16, halo);
    EXPECT_EQ(parts.is_sure, halo > 10) << halo;
    const bool is_same = parts.mesh.triangles == whole.triangles && parts.mesh.patch == whole.patch;
    EXPECT_TRUE(is_same || !parts.do_agree) << halo;
    wrong += !is_same;
    right += parts.do_agree;
  }
  EXPECT_GT(wrong, 0);
  EXPECT_GT(right, 0);
}

TEST(Parts, OfNothingAreNothing) {
  const support::Workers workers(1);
  const auto swapped = optimise_part({}, {}, limits_of(1), workers.context());
  ASSERT_TRUE(swapped.ok());
  EXPECT_TRUE(swapped->triangles.empty() && swapped->events.empty());
  EXPECT_TRUE(agree({}));
}

}  // namespace
}  // namespace scanmill::optimise
