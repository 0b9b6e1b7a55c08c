// SPDX-License-Identifier: Apache-2.0
#include "pipeline/coverage.hpp"

#include <algorithm>
#include <limits>

#include "cloud/over_blocks.hpp"
#include "geom/angles.hpp"
#include "pipeline/watched_points.hpp"

namespace scanmill::pipeline {
namespace {

constexpr std::size_t kMostPairs = 400;  // views
constexpr std::size_t kSeenBy = 8;
constexpr double kNoAngle = 1e9;

/// Bins of one block in the order in which points meet them. Points come row by row of a range map, so most repeat the
/// bin before them, or one of the row above: a table of bins met lately keeps these out, not always.
void bins_of_block(const PointBlock& block, const reduce::ReducedCloud& cloud, std::vector<LocalBin>& bins) {
  constexpr std::size_t kLately = 4096;
  constexpr std::int32_t kNowhere = std::numeric_limits<std::int32_t>::min();
  bins.clear();
  std::vector<LocalBin> lately(kLately, LocalBin{kNowhere, kNowhere, kNowhere});
  const Vec3 origin = cloud.lattice.origin;
  const double edge = cloud.lattice.edge_mm;
  double i = 0, j = 0, k = 0;  // the bin before
  for (const Vec3 p : block.positions) {
    const double x = (p.x - origin.x) / edge, y = (p.y - origin.y) / edge, z = (p.z - origin.z) / edge;
    if (!bins.empty() && x >= i && x < i + 1 && y >= j && y < j + 1 && z >= k && z < k + 1) continue;
    const BinKey key = bin_of(cloud.lattice, p);
    i = static_cast<double>(key.i), j = static_cast<double>(key.j), k = static_cast<double>(key.k);
    const LocalBin bin{static_cast<std::int32_t>(key.i - cloud.base.i), static_cast<std::int32_t>(key.j - cloud.base.j),
                       static_cast<std::int32_t>(key.k - cloud.base.k)};
    const auto mixed = static_cast<std::uint32_t>(bin[0]) * 73856093u ^ static_cast<std::uint32_t>(bin[1]) * 19349663u ^
                       static_cast<std::uint32_t>(bin[2]) * 83492791u;
    LocalBin& met = lately[(mixed ^ mixed >> 16) % kLately];
    if (met == bin) continue;
    met = bin;
    bins.push_back(bin);
  }
}

/// Rows of the bins that one block touches, ascending, each once.
void rows_of_block(const PointBlock& block, const reduce::ReducedCloud& cloud, BinIndex::Reader& reader,
                   std::vector<LocalBin>& bins, std::vector<std::int32_t>& rows) {
  bins_of_block(block, cloud, bins);
  std::sort(bins.begin(), bins.end());
  bins.erase(std::unique(bins.begin(), bins.end()), bins.end());
  rows.assign(bins.size(), kNoSlot);
  reader.rows_of(bins, rows);
  std::erase(rows, kNoSlot);
  std::sort(rows.begin(), rows.end());
}

double angle_at(const reduce::ReducedCloud& cloud, std::size_t row, const ViewPoint& view) {
  if (cloud.frame_valid[row] == 0) return kNoAngle;
  Vec3 towards;
  if (view.eye)
    towards = *view.eye - cloud.projected[row];
  else if (view.direction)
    towards = *view.direction;
  else
    return kNoAngle;
  const double angle = degrees_between(cloud.normal[row], towards);
  return std::min(angle, 180 - angle);
}

double median(std::vector<double>& values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Views that see each bin, view after view: rows of view v are unique and ascending.
struct Seen {
  std::vector<std::vector<std::int32_t>> rows;  // per view
};

void count_pairs(const Seen& seen, std::size_t bins, Coverage& out) {
  const std::size_t n = seen.rows.size();
  std::vector<std::uint32_t> begin(bins + 1, 0);
  for (const auto& rows : seen.rows)
    for (const std::int32_t row : rows) ++begin[static_cast<std::size_t>(row) + 1];
  for (std::size_t row = 0; row < bins; ++row) begin[row + 1] += begin[row];
  std::vector<std::uint32_t> views(begin[bins]), next(begin.begin(), begin.end() - 1);
  for (std::size_t v = 0; v < n; ++v)
    for (const std::int32_t row : seen.rows[v])
      views[next[static_cast<std::size_t>(row)]++] = static_cast<std::uint32_t>(v);
  for (std::size_t v = 0; n <= kMostPairs && v < n; ++v) out.views[v].shared.assign(n, 0);
  for (std::size_t row = 0; row < bins; ++row) {
    const std::uint32_t from = begin[row], to = begin[row + 1];
    if (to == from) continue;
    ++out.seen_by[std::min<std::size_t>(to - from, kSeenBy) - 1];
    if (to - from == 1) ++out.views[views[from]].only_here;
    if (n > kMostPairs) continue;
    for (std::uint32_t a = from; a < to; ++a)
      for (std::uint32_t b = from; b < to; ++b)
        if (a != b) ++out.views[views[a]].shared[views[b]];
  }
  for (ViewCoverage& view : out.views)
    for (std::size_t other = 0; other < view.shared.size(); ++other) {
      const double share = view.bins > 0 ? static_cast<double>(view.shared[other]) / static_cast<double>(view.bins) : 0;
      if (share <= view.best_overlap) continue;
      view.best_overlap = share;
      view.best_neighbour = other;
    }
}

}  // namespace

Result<Coverage> coverage_of(const ScanPoints& points, const reduce::ReducedCloud& cloud, const Context& context,
                             Progress& progress) {
  const WatchedPoints watched(points, "coverage", progress);
  const std::size_t blocks = points.block_count(), bins = cloud.size();
  std::vector<std::vector<std::int32_t>> touched(blocks);
  std::vector<std::size_t> view_of(blocks, 0);
  std::vector<BinIndex::Reader> readers;
  std::vector<std::vector<LocalBin>> scratch(static_cast<std::size_t>(context.loop.threads()));
  for (int w = 0; w < context.loop.threads(); ++w) readers.emplace_back(cloud.index);
  std::vector<PointBlock> buffers(static_cast<std::size_t>(context.loop.threads()));
  FirstBlockError first;
  context.loop.run(blocks, [&](std::size_t number, int worker) {
    if (context.cancel.is_set() || first.is_before(number)) return;
    const auto w = static_cast<std::size_t>(worker);
    if (auto read = watched.read_block(number, buffers[w]); !read.ok())
      return first.report(number, std::move(read).error());
    rows_of_block(buffers[w], cloud, readers[w], scratch[w], touched[number]);
    view_of[number] = index_of(buffers[w].view);
  });
  TRY(first.take(context));

  Coverage out;
  out.bin_mm = cloud.lattice.edge_mm;
  out.bins = bins;
  out.seen_by.assign(kSeenBy, 0);
  out.views.resize(points.views().size());
  Seen seen;
  seen.rows.resize(out.views.size());
  for (std::size_t v = 0, number = 0; v < out.views.size(); ++v) {
    std::vector<std::int32_t>& rows = seen.rows[v];
    for (; number < blocks && view_of[number] == index_of(points.views()[v].id); ++number) {
      rows.insert(rows.end(), touched[number].begin(), touched[number].end());
      touched[number] = {};
    }
    std::sort(rows.begin(), rows.end());
    rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
    out.views[v].bins = rows.size();
  }
  count_pairs(seen, bins, out);
  std::vector<double> best(bins, kNoAngle), angles;
  for (std::size_t v = 0; v < out.views.size(); ++v) {
    angles.clear();
    for (const std::int32_t row : seen.rows[v]) {
      const double angle = angle_at(cloud, static_cast<std::size_t>(row), points.views()[v].view_point);
      if (angle == kNoAngle) continue;
      angles.push_back(angle);
      double& least = best[static_cast<std::size_t>(row)];
      least = std::min(least, angle);
    }
    out.views[v].median_angle_deg = median(angles);
  }
  std::erase(best, kNoAngle);
  out.bins_with_angle = best.size();
  out.bins_within_60_deg =
      static_cast<std::uint64_t>(std::count_if(best.begin(), best.end(), [](double angle) { return angle <= 60; }));
  out.median_best_angle_deg = median(best);
  return out;
}

}  // namespace scanmill::pipeline
