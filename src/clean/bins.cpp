// SPDX-License-Identifier: Apache-2.0
#include "clean/bins.hpp"

#include <algorithm>
#include <cmath>

#include "base/text.hpp"
#include "mesh/groups.hpp"

namespace scanmill::clean {
namespace {

constexpr double kMaxLocal = 1 << 30;
constexpr int kFarthest = 8;  // bins; what a reader of the index sees
constexpr std::size_t kGrain = 4096;

std::int64_t floor_to_int(double u) {
  const auto i = static_cast<std::int64_t>(u);
  return i - (u < static_cast<double>(i));
}

std::uint8_t distance_of(const LocalBin& bin, std::int64_t neighbours, const CountedBins& bins,
                         BinIndex::Reader& reader, std::vector<std::int32_t>& rows) {
  for (int radius = 1; radius <= kFarthest; ++radius) {
    rows.clear();
    reader.window(bin, radius, rows);
    std::int64_t points = -1;  // one of its own is no neighbour
    for (const std::int32_t row : rows) points += bins.counts[static_cast<std::size_t>(row)];
    if (points >= neighbours) return static_cast<std::uint8_t>(radius);
  }
  return kFarthest + 1;
}

void judge_distances(const CountedBins& bins, const BinIndex& index, const StatisticalRule& rule,
                     std::vector<BinFate>& fate, OutlierReport& report, const Context& context) {
  std::vector<std::uint8_t> distance(bins.bins.size());
  for_each_range(context, bins.bins.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    BinIndex::Reader reader(index);
    std::vector<std::int32_t> rows;
    for (std::size_t row = begin; row < end; ++row)
      distance[row] = distance_of(bins.bins[row], rule.neighbours, bins, reader, rows);
  });
  std::int64_t count = 0, sum = 0, squares = 0;
  for (std::size_t row = 0; row < distance.size(); ++row) {
    const std::int64_t d = distance[row], n = bins.counts[row];
    count += n;
    sum += n * d;
    squares += n * d * d;
  }
  if (count == 0) return;
  const double n = static_cast<double>(count);
  report.mean_distance = static_cast<double>(sum) / n;
  const double variance = static_cast<double>(squares) / n - report.mean_distance * report.mean_distance;
  report.deviation = std::sqrt(std::max(variance, 0.0));
  report.greatest_distance = std::max(report.mean_distance + rule.deviations * report.deviation, 1.0);
  for (std::size_t row = 0; row < distance.size(); ++row) {
    if (!(distance[row] > report.greatest_distance)) continue;
    fate[row] = BinFate::Statistical;
    ++report.statistical_bins;
    report.statistical_points += static_cast<std::uint64_t>(bins.counts[row]);
  }
}

void judge_components(const CountedBins& bins, const BinIndex& index, const OutlierRules& rules,
                      std::vector<BinFate>& fate, OutlierReport& report) {
  const auto range = static_cast<int>(rules.component_range_bins);
  Groups groups(bins.bins.size());
  BinIndex::Reader reader(index);
  std::vector<std::int32_t> near;
  for (std::uint32_t row = 0; row < bins.bins.size(); ++row) {
    if (fate[row] != BinFate::Kept) continue;
    near.clear();
    reader.window(bins.bins[row], range, near);
    for (const std::int32_t other : near)
      if (static_cast<std::uint32_t>(other) < row && fate[static_cast<std::size_t>(other)] == BinFate::Kept)
        groups.join(row, static_cast<std::uint32_t>(other));
  }
  std::vector<std::int64_t> points(bins.bins.size(), 0);
  std::int64_t all = 0;
  for (std::uint32_t row = 0; row < bins.bins.size(); ++row) {
    if (fate[row] != BinFate::Kept) continue;
    points[groups.root(row)] += bins.counts[row];
    all += bins.counts[row];
  }
  const double least = std::max(rules.min_component_points.value_or(0),
                                rules.min_component_share.value_or(0) * static_cast<double>(all));
  for (std::uint32_t row = 0; row < bins.bins.size(); ++row) {
    if (fate[row] != BinFate::Kept) continue;
    const std::uint32_t root = groups.root(row);
    const auto of_piece = static_cast<std::uint64_t>(points[root]);
    const bool goes = static_cast<double>(of_piece) < least;
    if (root == row) {
      ++report.components;
      report.components_removed += goes;
      if (goes) report.largest_removed = std::max(report.largest_removed, of_piece);
    }
    if (!goes) continue;
    fate[row] = BinFate::Component;  // groups are joined: nobody looks at this row's fate any more but the sums
    ++report.component_bins;
    report.component_points += static_cast<std::uint64_t>(bins.counts[row]);
  }
}

}  // namespace

OutlierLattice outlier_lattice(double edge_mm, Vec3 near) {
  OutlierLattice lattice{edge_mm, {}};
  auto corner = [&](double p) { return floor_to_int(std::clamp(p / edge_mm, -0x1p51, 0x1p51)) & ~std::int64_t{1023}; };
  lattice.base = {corner(near.x), corner(near.y), corner(near.z)};
  return lattice;
}

bool OutlierLattice::bin_of(Vec3 p, LocalBin& bin) const {
  const double u[3] = {p.x / edge_mm, p.y / edge_mm, p.z / edge_mm};
  const std::int64_t from[3] = {base.i, base.j, base.k};
  for (std::size_t k = 0; k < 3; ++k) {
    if (!(std::abs(u[k]) < 0x1p52)) return false;
    const double local = static_cast<double>(floor_to_int(u[k]) - from[k]);
    if (!(std::abs(local) < kMaxLocal)) return false;
    bin[k] = static_cast<std::int32_t>(local);
  }
  return true;
}

Result<void> BinCounter::add(const OutlierLattice& lattice, std::span<const Vec3> points) {
  bins_.resize(points.size());
  slots_.resize(points.size());
  for (std::size_t i = 0; i < points.size(); ++i)
    if (!lattice.bin_of(points[i], bins_[i]))
      return fail(Code::BadInput, "clean.outliers: the cloud is more than 2^30 bins of " +
                                      number_text(lattice.edge_mm) +
                                      " mm wide; stray points far away (cut them off by clean.keep_box), wrong units, "
                                      "or too small a bin edge");
  tree_.slots_of(bins_, slots_);
  counts_.resize(static_cast<std::size_t>(tree_.size()), 0);
  for (const std::int32_t slot : slots_) ++counts_[static_cast<std::size_t>(slot)];
  return {};
}

void BinCounter::add(const BinCounter& other, const BinKey& base) {
  const auto entries = other.tree_.sorted(base);
  bins_.resize(entries.size());
  slots_.resize(entries.size());
  for (std::size_t i = 0; i < entries.size(); ++i) bins_[i] = entries[i].bin;
  tree_.slots_of(bins_, slots_);
  counts_.resize(static_cast<std::size_t>(tree_.size()), 0);
  for (std::size_t i = 0; i < entries.size(); ++i)
    counts_[static_cast<std::size_t>(slots_[i])] += other.counts_[static_cast<std::size_t>(entries[i].slot)];
}

CountedBins BinCounter::sorted(const BinKey& base) const {
  CountedBins out;
  const auto entries = tree_.sorted(base);
  out.bins.reserve(entries.size());
  out.counts.reserve(entries.size());
  for (const BinTree::Entry& entry : entries) {
    out.bins.push_back(entry.bin);
    out.counts.push_back(counts_[static_cast<std::size_t>(entry.slot)]);
  }
  return out;
}

std::vector<BinFate> judge_bins(const CountedBins& bins, const OutlierRules& rules, OutlierReport& report,
                                const Context& context) {
  report = {};
  report.bins = bins.bins.size();
  for (const std::int64_t count : bins.counts) report.points += static_cast<std::uint64_t>(count);
  std::vector<BinFate> fate(bins.bins.size(), BinFate::Kept);
  const BinIndex index = BinIndex::over(bins.bins);
  if (rules.statistical) judge_distances(bins, index, *rules.statistical, fate, report, context);
  if (rules.min_component_points || rules.min_component_share) judge_components(bins, index, rules, fate, report);
  return fate;
}

}  // namespace scanmill::clean
