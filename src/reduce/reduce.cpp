// SPDX-License-Identifier: Apache-2.0
// Voxel-bin reduction: keep one measured point per bin (Bradley 2001, section 4.1).
//
// The paper keeps the point nearest the bin's centre and drops points by c1 and c2 on measured positions. With noise,
// bins that the surface only grazes are then filled by the tail of the noise; `representative: surface` keeps the point
// nearest the foot of the bin's centre on the local plane instead, and c2 is judged on positions projected to that
// plane.
#include "reduce/reduce.hpp"

#include <algorithm>

#include "base/large_pages.hpp"
#include "base/text.hpp"
#include "reduce/binning.hpp"
#include "reduce/drops.hpp"
#include "reduce/frame.hpp"
#include "reduce/parts.hpp"

namespace scanmill::reduce {
namespace {

/// Relative to the median residual, and in bin edges: above both a bin lies on a crease.
constexpr double kCreaseOverMedian = 2.5, kCreaseResidual = 0.2;
/// Noise, in bin edges, from which frames take the 5x5x5 bins (docs/algorithm.md: 3x3x3 is better below, on every cloud
/// tried).
constexpr double kNoisyFrom = 0.15;
/// A foot farther than this from the measured point is no foot of this surface; the measured point is used.
constexpr double kMaxProjection = 1.5;
/// mm; a cloud outside these is no scan, and the search for a bin edge would leave the range of double.
constexpr double kLeastExtent = 1e-9, kGreatestExtent = 1e12;
constexpr std::size_t kGrain = 1 << 15;  // rows

std::int64_t round_down(std::int64_t value) { return value & ~std::int64_t{1023}; }

/// `somewhere` may lie anywhere: a base within 2^50 bins of the origin keeps all bin numbers in range, and points that
/// are no 2^30 bins from it are refused when they are placed.
LocalFrame local_frame(const Lattice& lattice, Vec3 somewhere) {
  auto within = [&](double p, double origin) {
    const double limit = 0x1p50 * lattice.edge_mm;
    return std::clamp(p, origin - limit, origin + limit);
  };
  const BinKey bin = bin_of(lattice, {within(somewhere.x, lattice.origin.x), within(somewhere.y, lattice.origin.y),
                                      within(somewhere.z, lattice.origin.z)});
  return {lattice, {round_down(bin.i), round_down(bin.j), round_down(bin.k)}};
}

Result<void> check(const LatticeParams& lattice, const Params& params) {
  std::vector<std::string> problems = problems_of(LatticeParams::fields(), &lattice);
  for (std::string& problem : problems_of(Params::fields(), &params)) problems.push_back(std::move(problem));
  const int given = lattice.bin_mm.has_value() + lattice.target_points.has_value() + lattice.target_bins.has_value();
  if (given != 1)
    problems.push_back("lattice: found " + std::to_string(given) +
                       " of bin_mm, target_points and target_bins; exactly one must be given");
  if (problems.empty()) return {};
  std::string text = problems.front();
  for (std::size_t i = 1; i < problems.size(); ++i) text += "\n" + problems[i];
  return fail(Code::BadParameter, text);
}

/// The cloud before frames: bins, their first points and counts.
ReducedCloud first_cloud(const LocalFrame& frame, BinTotals& totals, const Params& params, const Context& context) {
  ReducedCloud cloud;
  cloud.lattice = frame.lattice;
  cloud.base = frame.base;
  const std::size_t n = totals.bins.size();
  cloud.bins = std::move(totals.bins);
  resize_large(cloud.measured, n);
  resize_large(cloud.source, n);
  resize_large(cloud.counts, n);
  cloud.drop.assign(n, Drop::Kept);
  for_each_range(context, n, kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t row = begin; row < end; ++row) {
      const Cell& cell = totals.cells[row];
      cloud.measured[row] = cell.position;
      cloud.source[row] = {cell.view, cell.row};
      cloud.counts[row] = static_cast<std::int64_t>(cell.sums.count);
      if (cloud.counts[row] < params.min_points_per_bin) cloud.drop[row] = Drop::TooFewPoints;
    }
  });
  return cloud;
}

/// For questions about windows alone.
ReducedCloud bare_cloud(const LocalFrame& frame, std::vector<LocalBin> bins) {
  ReducedCloud cloud;
  cloud.lattice = frame.lattice;
  cloud.base = frame.base;
  cloud.bins = std::move(bins);
  cloud.index = BinIndex::over(cloud.bins);
  return cloud;
}

Levels levels_of(const ReducedCloud& cloud, const BinCells& cells, const Context& context) {
  const double noise = noise_of(cloud, cells, context);
  return {noise, noise > kNoisyFrom ? 2 : 1};
}

/// Second pass: replaces the winners by the points nearest to the feet of the bins' centres.
Result<void> pick_representatives(const PointSource& points, const LocalFrame& frame, const Frames& frames,
                                  const Params& params, ReducedCloud& cloud, const Context& context) {
  const std::vector<Target> targets = targets_of(frame, cloud.bins, frames, frames.median_residual, params);
  TRY_ASSIGN(const std::vector<Winner> winners, pick_against(points, frame, cloud.index, targets, context));
  for (std::size_t row = 0; row < cloud.size(); ++row) {
    cloud.measured[row] = winners[row].position;
    cloud.source[row] = winners[row].source;
  }
  return {};
}

void project(ReducedCloud& cloud, const Frames& frames, const Context& context) {
  const double limit = kMaxProjection * cloud.lattice.edge_mm;
  resize_large(cloud.projected, cloud.size());
  for_each_range(context, cloud.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t row = begin; row < end; ++row) {
      const double off = dot(cloud.measured[row] - frames.centroid[row], frames.normal[row]);
      const bool moves = frames.valid[row] && std::abs(off) < limit;
      cloud.projected[row] = moves ? cloud.measured[row] - frames.normal[row] * off : cloud.measured[row];
    }
  });
}

void take_frames(ReducedCloud& cloud, Frames& frames, const Params& params, const Context& context) {
  project(cloud, frames, context);
  cloud.normal = std::move(frames.normal);
  cloud.residual = std::move(frames.residual);
  cloud.variation = std::move(frames.variation);
  cloud.plane_distance = std::move(frames.plane_distance);
  cloud.frame_valid = std::move(frames.valid);
  cloud.sign_known = std::move(frames.sign_known);
  drop_alone(cloud, params, context);
}

Result<Reduction> with_report(ReducedCloud cloud, const ReadCounts& counts, const Levels& levels,
                              double median_residual) {
  Reduction out{std::move(cloud), {}};
  Report& report = out.report;
  report.points_read = counts.points_read;
  report.not_finite = counts.not_finite;
  report.sensor_invalid = counts.sensor_invalid;
  report.points_used = counts.points_used;
  report.bounds = counts.bounds;
  report.noise = levels.noise;
  report.frame_radius = levels.frame_radius;
  report.median_residual = median_residual;
  report.bin_mm = out.cloud.lattice.edge_mm;
  count_drops(out.cloud, report);
  TRY(check_numbers(report.bins, report.kept, report.bin_mm));
  return out;
}

Result<Reduction> reduce_on(const PointSource& points, const Lattice& lattice, Vec3 somewhere, const Params& params,
                            const Context& context) {
  const LocalFrame frame = local_frame(lattice, somewhere);
  ReadCounts counts;
  TRY_ASSIGN(BinTotals totals, bin_points(points, frame, counts, context));
  ReducedCloud cloud = first_cloud(frame, totals, params, context);
  cloud.index = BinIndex::over(cloud.bins);
  const Levels levels = levels_of(cloud, totals.cells, context);
  Frames frames = frames_of(cloud, totals.cells, levels.frame_radius, context);
  totals.cells = {};
  if (params.representative == Representative::Surface)
    TRY(pick_representatives(points, frame, frames, params, cloud, context));
  const double median_residual = frames.median_residual;
  take_frames(cloud, frames, params, context);
  frames = {};
  drop_near(cloud, {}, params, context);
  if (context.cancel.is_set()) return fail(Code::Cancelled, "stopped on request");
  TRY_ASSIGN(Reduction out, with_report(std::move(cloud), counts, levels, median_residual));
  out.report.index_bytes = totals.index_bytes;
  out.report.record_bytes = totals.cell_bytes;
  return out;
}

/// Bisection on the bin edge: occupied bins fall as the edge grows. Ends within 2 % of the wanted number or after 24
/// trials. The edge found is rounded to three significant digits, so that it can be written into a job.
Result<double> edge_for_bins(const PointSource& points, const ReadCounts& seen, Vec3 origin, double wanted,
                             const Context& context) {
  const Bounds& bounds = seen.bounds;
  const Vec3 size = bounds.size();
  const double extent = std::max({size.x, size.y, size.z});
  if (!(extent > kLeastExtent))
    return fail(Code::BadInput, (seen.points_used == 1 ? std::string("holds one point")
                                                       : "all " + grouped(seen.points_used) + " points coincide") +
                                    "; wanted points of a surface");
  if (!(extent < kGreatestExtent))
    return fail(Code::BadInput,
                "the cloud is " + number_text(extent) + " mm wide; stray points far away, or wrong units");
  double low = extent / (2 * std::sqrt(wanted)) / 8, high = extent * 2;
  double edge = extent / std::sqrt(wanted);
  for (int trial = 0; trial < 24; ++trial) {
    const Lattice lattice{edge, origin};
    TRY_ASSIGN(const std::uint64_t bins, count_bins(points, local_frame(lattice, bounds.low), context));
    const double ratio = static_cast<double>(bins) / wanted;
    if (ratio > 0.98 && ratio < 1.02) break;
    if (ratio > 1)
      low = std::max(low, edge);
    else
      high = std::min(high, edge);
    const double guess = edge * std::sqrt(ratio);  // surfaces: bins go with the inverse square of the edge
    edge = guess > low && guess < high ? guess : (low + high) / 2;
  }
  double scale = 1;
  while (edge * scale < 100) scale *= 10;
  while (edge * scale >= 1000) scale /= 10;
  return static_cast<double>(static_cast<std::int64_t>(edge * scale + 0.5)) / scale;
}

}  // namespace

bool is_cuttable(const LatticeParams& lattice) {
  return lattice.bin_mm.has_value() && lattice.origin == Origin::Absolute;
}

Result<LocalFrame> frame_of_parts(const PointSource& points, const LatticeParams& lattice, const Params& params) {
  TRY(check(lattice, params));
  TRY_ASSIGN(const Vec3 somewhere, first_point(points));
  return local_frame({*lattice.bin_mm, {}}, somewhere);
}

Levels levels_of_parts(const LocalFrame& frame, std::vector<LocalBin> bins, const BinCells& cells,
                       const Context& context) {
  return levels_of(bare_cloud(frame, std::move(bins)), cells, context);
}

Frames frames_of_parts(const LocalFrame& frame, std::vector<LocalBin> bins, const BinCells& cells, std::int32_t radius,
                       const Context& context) {
  return frames_of(bare_cloud(frame, std::move(bins)), cells, radius, context);
}

std::vector<Target> targets_of(const LocalFrame& frame, std::span<const LocalBin> bins, const Frames& frames,
                               double median_residual, const Params& params) {
  const double crease_from = std::max(kCreaseOverMedian * median_residual, kCreaseResidual);
  std::vector<Target> targets(bins.size());
  for (std::size_t row = 0; row < bins.size(); ++row) {
    const BinKey key{frame.base.i + bins[row][0], frame.base.j + bins[row][1], frame.base.k + bins[row][2]};
    const Vec3 centre = centre_of(frame.lattice, key), n = frames.normal[row];
    Target& target = targets[row];
    target.normal = n;
    target.foot = centre - n * dot(centre - frames.centroid[row], n);
    target.crease = params.edge_aware && frames.residual[row] > crease_from;
    if (target.crease) target.foot = frames.centroid[row];
  }
  return targets;
}

ReducedCloud points_of_parts(const LocalFrame& frame, BinTotals totals, Frames frames, const Params& params,
                             const Context& context) {
  ReducedCloud part = first_cloud(frame, totals, params, context);
  take_frames(part, frames, params, context);
  return part;
}

std::vector<std::uint8_t> thin_part(ReducedCloud& part, const std::vector<std::uint8_t>& seen, const Params& params,
                                    const Context& context) {
  return drop_near(part, seen, params, context);
}

Result<Reduction> join_parts(ReducedCloud cloud, const ReadCounts& counts, const Levels& levels,
                             double median_residual) {
  return with_report(std::move(cloud), counts, levels, median_residual);
}

Result<Reduction> reduce_cloud(const PointSource& points, const LatticeParams& params, const Params& reduce,
                               const Context& context) {
  TRY(check(params, reduce));
  Lattice lattice;
  TRY_ASSIGN(Vec3 somewhere, first_point(points));
  const bool needs_bounds = params.origin == Origin::Bounds || !params.bin_mm;
  if (!needs_bounds) {
    lattice.edge_mm = *params.bin_mm;
    return reduce_on(points, lattice, somewhere, reduce, context);
  }
  TRY_ASSIGN(const ReadCounts extent, read_bounds(points, context));
  if (params.origin == Origin::Bounds) lattice.origin = extent.bounds.low;
  somewhere = extent.bounds.low;
  if (params.bin_mm) {
    lattice.edge_mm = *params.bin_mm;
    return reduce_on(points, lattice, somewhere, reduce, context);
  }
  const double wanted = params.target_bins ? *params.target_bins : *params.target_points;
  TRY_ASSIGN(lattice.edge_mm, edge_for_bins(points, extent, lattice.origin, wanted, context));
  if (params.target_bins) return reduce_on(points, lattice, somewhere, reduce, context);
  // Kept points are a share of the bins that thinning decides; correct for it twice.
  double aim = wanted;
  for (int round = 0;; ++round) {
    TRY_ASSIGN(Reduction out, reduce_on(points, lattice, somewhere, reduce, context));
    const double kept = static_cast<double>(out.report.kept);
    if (round == 2 || kept == 0 || std::abs(kept / wanted - 1) < 0.03) return out;
    aim *= wanted / kept;
    TRY_ASSIGN(lattice.edge_mm, edge_for_bins(points, extent, lattice.origin, aim, context));
  }
}

}  // namespace scanmill::reduce
