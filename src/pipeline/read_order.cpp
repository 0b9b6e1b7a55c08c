// SPDX-License-Identifier: Apache-2.0
#include "pipeline/read_order.hpp"

#include <atomic>
#include <optional>

#include "base/paged_memory.hpp"
#include "base/text.hpp"
#include "cloud/gathered_points.hpp"
#include "cloud/spatial_order.hpp"
#include "pipeline/bin_forecast.hpp"
#include "pipeline/watched_points.hpp"
#include "reduce/parts.hpp"

namespace scanmill::pipeline {
namespace {

/// Points up to which no order matters; from the second on it always may.
constexpr std::uint64_t kFewPoints = 1000000, kManyPoints = 20000000;
/// Share of the cloud that a block spans where points stand in no order (GatheredPoints::scatter_of).
constexpr double kScattered = 0.2;
/// Points a bin that a cloud is taken to have before it is looked at.
constexpr std::uint64_t kPointsPerBin = 8;

std::unique_ptr<PointSource> by_order(const PointSource& points, BlockOrder blocks) {
  return std::make_unique<OrderedPoints>(points, std::move(blocks.order));
}

/// Refuses what memory and disk together cannot hold.
Result<void> check_room(std::uint64_t bins, std::uint64_t bytes) {
  const auto room = paged::room();
  if (!room || bytes <= room->plain + room->disk) return {};
  return fail(Code::NoSpace,
              "about " + grouped(bins) + " bins are occupied, which need " + bytes_text(bytes) +
                  " of memory and disk; found " + bytes_text(room->plain) + " of memory under the cap and " +
                  bytes_text(room->disk) +
                  " of disk beside it; raise resources.memory or disk (--memory, --disk), "
                  "free space, or choose larger bins",
              "memory");
}

Result<std::unique_ptr<PointSource>> look_over(const PointSource& points, const reduce::LatticeParams& lattice,
                                               const reduce::Params& params, const Context& context,
                                               Progress& progress) {
  const WatchedPoints watched(points, "order", progress);
  std::optional<BinForecast> forecast;
  if (reduce::is_cuttable(lattice)) {
    TRY_ASSIGN(const reduce::LocalFrame frame, reduce::frame_of_parts(points, lattice, params));
    forecast.emplace(frame, context.loop.threads());
  }
  std::atomic<std::uint64_t> point_bytes{0};
  TRY_ASSIGN(BlockOrder blocks, spatial_order(watched, context, [&](int worker, const PointBlock& block) {
               if (forecast) forecast->look(worker, block);
               const std::uint64_t bytes = block.positions.empty() ? 0 : GatheredPoints::bytes_of(block.positions[0]);
               if (bytes > point_bytes.load(std::memory_order_relaxed)) point_bytes = bytes;
             }));
  const std::uint64_t bins = forecast ? forecast->bins() : 0, bytes = bins * BinForecast::kBytesPerBin;
  TRY(check_room(bins, bytes));
  TRY_ASSIGN(const double scatter, GatheredPoints::scatter_of(points));
  const auto room = paged::room();
  if (scatter > kScattered && (!room || bytes + points.expected_points() * point_bytes < room->plain + room->disk)) {
    auto gathered = GatheredPoints::gather(WatchedPoints(points, "gather", progress), blocks.bounds, context);
    if (gathered.ok()) return std::unique_ptr<PointSource>(std::move(gathered).value());
    if (gathered.error().code != Code::Unsupported) return std::move(gathered).error();
  }
  return by_order(points, std::move(blocks));
}

}  // namespace

Result<std::unique_ptr<PointSource>> in_best_order(const PointSource& points, const reduce::LatticeParams& lattice,
                                                   const reduce::Params& params, const Context& context,
                                                   Progress& progress) {
  return points.expected_points() < kManyPoints ? gathered_if_scattered(points, lattice, params, context, progress)
                                                : look_over(points, lattice, params, context, progress);
}

Result<std::unique_ptr<PointSource>> gathered_if_scattered(const PointSource& points,
                                                           const reduce::LatticeParams& lattice,
                                                           const reduce::Params& params, const Context& context,
                                                           Progress& progress) {
  const auto room = paged::room();
  const std::uint64_t count = points.expected_points();
  if (!room || count < kFewPoints || count / kPointsPerBin * BinForecast::kBytesPerBin <= room->plain)
    return std::unique_ptr<PointSource>();
  TRY_ASSIGN(const double scatter, GatheredPoints::scatter_of(points));
  if (scatter <= kScattered) return std::unique_ptr<PointSource>();
  return look_over(points, lattice, params, context, progress);
}

}  // namespace scanmill::pipeline
