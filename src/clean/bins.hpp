// SPDX-License-Identifier: Apache-2.0
// Outliers by bins, so that memory follows the occupied bins, not the points. Internal to `clean`.
#pragma once
#include <cstdint>
#include <vector>

#include "base/context.hpp"
#include "base/result.hpp"
#include "clean/params.hpp"
#include "cloud/cloud.hpp"
#include "lattice/bin_index.hpp"

namespace scanmill::clean {

/// The lattice the outlier rules work on: anchored at the global origin, never at the data.
struct OutlierLattice {
  double edge_mm = 1;
  BinKey base;  // local bins are counted from here; a multiple of 1024 near the cloud
  /// False when the bin does not fit 32 bits.
  bool bin_of(Vec3 p, LocalBin& bin) const;
};
OutlierLattice outlier_lattice(double edge_mm, Vec3 near);

/// Occupied bins in ascending key with their points.
struct CountedBins {
  std::vector<LocalBin> bins;
  std::vector<std::int64_t> counts;
};

/// Bins of one worker.
class BinCounter {
 public:
  /// errors  BadInput when a point lies too far from the base
  Result<void> add(const OutlierLattice& lattice, std::span<const Vec3> points);
  void add(const BinCounter& other, const BinKey& base);
  CountedBins sorted(const BinKey& base) const;

 private:
  BinTree tree_;
  std::vector<std::int64_t> counts_;
  std::vector<LocalBin> bins_;
  std::vector<std::int32_t> slots_;
};

enum class BinFate : std::uint8_t { Kept, Statistical, Component };

struct OutlierReport {
  std::uint64_t points = 0, bins = 0;
  // Statistical rule, in bins: distance to the neighbours over all points, and the distance above which points go.
  double mean_distance = 0, deviation = 0, greatest_distance = 0;
  std::uint64_t statistical_bins = 0, statistical_points = 0;
  std::uint64_t components = 0, components_removed = 0, component_bins = 0, component_points = 0;
  std::uint64_t largest_removed = 0;  // points of the largest piece that went
};

/// Statistical rule: the distance of a bin is the least r in 1 .. 8 for which the (2r+1)^3 bins around it hold
/// `neighbours` points beside one of its own, 9 where there is none. Over all points (each with its bin's distance)
/// mean and standard deviation; bins with a distance above mean + deviations x standard deviation, and above 1, are
/// outliers. Component rule: of the bins left, those within component_range_bins of each other on every axis belong
/// together; pieces below min_component_points, or below min_component_share of the points left, are outliers.
///
/// returns  the fate of each bin; all sums are integers, so neither order nor threads matter
/// cost     0.3 us per bin and rule; isolated bins more
std::vector<BinFate> judge_bins(const CountedBins& bins, const OutlierRules& rules, OutlierReport& report,
                                const Context& context);

}  // namespace scanmill::clean
