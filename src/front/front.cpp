// SPDX-License-Identifier: Apache-2.0
// Seeds, the order of patches, and their union; the growth of one patch is patch_growth.cpp.
#include "front/front.hpp"

#include <algorithm>
#include <numeric>

#include "base/text.hpp"
#include "front/patch_growth.hpp"

namespace scanmill::front {
namespace {

/// Automatic seeds keep this distance from each other, in bin edges: about the size of the smallest patch worth having.
constexpr double kSeedSpacing = 8;
/// Layers nearer than this, in bin edges, cannot both be surface: bins themselves do not tell them apart.
constexpr double kClearance = 0.5;
/// Projected neighbours on curved surface overlap by a rim; a fiftieth of the bin lets them.
constexpr double kTolerance = 0.02;

Rules rules_of(const Input& input) {
  return {input.limits.range_bins * input.edge_mm, cos_of_degrees(input.limits.min_angle_deg),
          input.limits.normal_dot(), kClearance * input.edge_mm, kTolerance * input.edge_mm};
}

Result<void> check(const Input& input) {
  const std::size_t n = input.points.size();
  if (n > kMaxPoints) {
    return fail(Code::Unsupported, "engine front grows up to " + grouped(kMaxPoints) + " points, here are " +
                                       grouped(n) + "; use engine stars, or larger bins");
  }
  if (!(input.edge_mm > 0) || !std::isfinite(input.edge_mm))
    return fail(Code::BadParameter, "bin edge is " + number_text(input.edge_mm) + " mm; it must be greater than 0");
  if (!input.normals.empty() && input.normals.size() != n)
    return fail(Code::Internal, "points and normals differ in length");
  for (std::size_t row = 0; row < n; ++row)
    if (!is_finite(input.points[row])) return fail(Code::Internal, "point " + std::to_string(row) + " is not finite");
  return {};
}

/// 1 - mean |n . n'| over the neighbours within g1; zero on a plane. Signs do not matter.
std::vector<double> normal_variation(const Input& input, const PointGrid& grid, double range) {
  std::vector<double> variation(input.points.size(), 0);
  if (input.normals.empty()) return variation;
  for (std::size_t row = 0; row < variation.size(); ++row) {
    double sum = 0, count = 0;
    grid.each_within(input.points[row], range, [&](std::uint32_t other) {
      sum += std::abs(dot(input.normals[row], input.normals[other]));
      count += 1;
    });
    variation[row] = 1 - sum / count;
  }
  return variation;
}

/// All rows, those where normals vary most first.
std::vector<std::uint32_t> rows_by_variation(const Input& input, const PointGrid& grid, double range) {
  const std::vector<double> variation = normal_variation(input, grid, range);
  std::vector<std::uint32_t> rows(variation.size());
  std::iota(rows.begin(), rows.end(), 0u);
  std::sort(rows.begin(), rows.end(), [&](std::uint32_t a, std::uint32_t b) {
    return variation[a] != variation[b] ? variation[a] > variation[b] : a < b;
  });
  return rows;
}

std::uint32_t nearest_row(std::span<const Vec3> points, Vec3 seed) {
  std::uint32_t best = 0;
  for (std::uint32_t row = 1; row < points.size(); ++row)
    if (norm2(points[row] - seed) < norm2(points[best] - seed)) best = row;
  return best;
}

/// What the seed loops share.
struct Run {
  const Input& input;
  const CancelFlag& cancel;
  PatchGrowth& growth;
  std::vector<Vec3> seeds;  // that grew a patch

  bool full() const { return seeds.size() >= input.max_patches; }
  Result<void> from(Vec3 seed) {
    if (cancel.is_set()) return fail(Code::Cancelled, "stopped between two patches");
    TRY_ASSIGN(const bool grown, growth.grow(seed, static_cast<std::uint32_t>(seeds.size()), cancel));
    if (grown) seeds.push_back(seed);
    return {};
  }
};

Result<void> grow_from_given_seeds(Run& run) {
  for (const Vec3 seed : run.input.seeds) {
    // A seed inside a finished patch would start at that patch's border, far from where the user put it.
    if (run.full() || run.growth.finished(nearest_row(run.input.points, seed))) continue;
    TRY(run.from(seed));
  }
  return {};
}

Result<void> grow_from_automatic_seeds(Run& run, const Surface& surface, const PointGrid& grid, double range) {
  const auto& points = run.input.points;
  const double spacing2 = kSeedSpacing * run.input.edge_mm * kSeedSpacing * run.input.edge_mm;
  const auto covered = [&](std::uint32_t row) { return !surface.around(row).empty(); };
  for (const std::uint32_t row : rows_by_variation(run.input, grid, range)) {
    if (run.full() || run.input.normals.empty()) break;
    const bool near_another = std::any_of(run.seeds.begin(), run.seeds.end(),
                                          [&](Vec3 seed) { return norm2(seed - points[row]) < spacing2; });
    if (!covered(row) && !near_another) TRY(run.from(points[row]));
  }
  for (std::uint32_t row = 0; row < points.size() && !run.full(); ++row)
    if (!covered(row)) TRY(run.from(points[row]));
  return {};
}

/// Key order, least row first, patches without triangles left out.
Output collect(const Surface& surface, const std::vector<Vec3>& seeds, const Refused& refused) {
  Output out;
  out.refused = refused.limits;
  out.refused_overlap = refused.overlap;
  std::vector<std::pair<Triangle, std::uint32_t>> rows;
  std::vector<std::uint32_t> number(seeds.size(), 0);
  for (std::uint32_t t = 0; t < surface.size(); ++t) {
    if (!surface.alive(t)) continue;
    Triangle corners = surface.triangle(t);
    std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
    rows.emplace_back(corners, surface.patch(t));
    number[surface.patch(t)] = 1;
  }
  std::sort(rows.begin(), rows.end());
  for (std::size_t patch = 0; patch < seeds.size(); ++patch) {
    if (number[patch] == 0) continue;
    number[patch] = static_cast<std::uint32_t>(out.seed_points.size());
    out.seed_points.push_back(seeds[patch]);
  }
  for (const auto& [corners, patch] : rows) {
    out.triangles.push_back(corners);
    out.patch.push_back(number[patch]);
  }
  return out;
}

}  // namespace

Result<Output> grow_fronts(const Input& input, const Context& context) {
  TRY(check(input));
  const Rules rules = rules_of(input);
  if (input.points.size() < 3) return Output{};
  const PointGrid grid(input.points, rules.reach());
  Surface surface(input.points);
  PatchGrowth growth(input.points, input.normals, grid, rules, surface);
  Run run{input, context.cancel, growth, {}};
  if (input.seeds.empty()) {
    TRY(grow_from_automatic_seeds(run, surface, grid, rules.range_mm));
  } else {
    TRY(grow_from_given_seeds(run));
  }
  growth.join_patches();
  surface.remove_lesser_fans();
  growth.close_seams();  // an ear joins the ends of one fan, so no vertex gets a second one here
  return collect(surface, run.seeds, growth.refused());
}

}  // namespace scanmill::front
