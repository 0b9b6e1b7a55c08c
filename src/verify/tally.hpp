// SPDX-License-Identifier: Apache-2.0
// Sums and ranks of distances that do not depend on the order of points. Internal to `verify`.
#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "verify/report.hpp"

namespace scanmill::verify {

__extension__ typedef __int128 Wide;
__extension__ typedef unsigned __int128 WideCount;

/// Distances count in whole units of 2^-20 bin edges; beyond 2^43 units (8 million bins) they count as that.
inline constexpr double kUnitsPerBin = 0x1p20;
inline constexpr std::int64_t kMostUnits = std::int64_t{1} << 43;
inline std::int64_t units_of(double distance, double units_per_mm) {
  const double units = distance * units_per_mm + 0.5;
  return units < static_cast<double>(kMostUnits) ? static_cast<std::int64_t>(units) : kMostUnits;
}

/// How many points lie at which distance: buckets of 4 units (2^-18 h) up to 4 h, then of 2^-19 of the distance. Grows
/// by pages where distances are; at most 90 MB however many points.
class Ranks {
 public:
  void add(std::int64_t units) { add(bucket_of(static_cast<std::uint64_t>(units)), 1); }
  void add(const Ranks& other);
  /// So many more points in a bucket.
  void add(std::size_t bucket, std::uint64_t count) {
    const std::size_t page = bucket / kPage;
    if (page >= pages_.size() || !pages_[page]) open(page);
    (*pages_[page])[bucket % kPage] += count;
  }
  /// body(bucket, count) for the buckets that hold points, ascending.
  template <class Body>
  void visit(Body body) const {
    for (std::size_t page = 0; page < pages_.size(); ++page)
      for (std::size_t n = 0; pages_[page] && n < kPage; ++n)
        if ((*pages_[page])[n] != 0) body(page * kPage + n, (*pages_[page])[n]);
  }
  /// Of 2^43 units and less.
  static constexpr std::size_t kBuckets = (std::size_t{1} << 20) + (std::size_t{22} << 19);
  /// Distance of the point with this rank in ascending order, in units: the middle of its bucket, off by at most 2
  /// units or 2^-20 of it.
  double at_rank(std::uint64_t rank) const;

 private:
  static constexpr std::size_t kPage = 4096;
  static std::size_t bucket_of(std::uint64_t units) {
    if (units < (1u << 22)) return units >> 2;
    const int top = 63 - __builtin_clzll(units);
    return (std::size_t{1} << 20) + (static_cast<std::size_t>(top - 22) << 19) + (units >> (top - 19)) - (1u << 19);
  }
  static double middle_of(std::size_t bucket);
  void open(std::size_t page);
  std::vector<std::unique_ptr<std::array<std::uint64_t, kPage>>> pages_;
};

struct Sums {
  std::uint64_t count = 0;
  Wide signed_sum = 0;
  WideCount sum = 0, sum2 = 0;
  double above = 0, below = 0;  // greatest distance on each side, mm
  void add(double distance, std::int64_t units, bool is_above) {
    ++count;
    signed_sum += is_above ? units : -units;
    sum += static_cast<std::uint64_t>(units);
    sum2 += static_cast<WideCount>(units) * static_cast<std::uint64_t>(units);
    double& greatest = is_above ? above : below;
    if (distance > greatest) greatest = distance;
  }
  void add(const Sums& other);
};

/// Figures in mm; percentiles where `ranks` are there.
DistanceFigures figures_of(const Sums& sums, const Ranks* ranks, double bin_mm);

/// The points with the greatest distances; ties by source, then position.
class Worst {
 public:
  static constexpr std::size_t kListed = 10;
  bool may_take(double distance) const { return list_.size() < kListed || distance >= list_.back().distance_mm; }
  void add(const WorstPoint& point);
  void add(const Worst& other) {
    for (const WorstPoint& point : other.list_) add(point);
  }
  const std::vector<WorstPoint>& list() const { return list_; }

 private:
  std::vector<WorstPoint> list_;  // greatest first
};

}  // namespace scanmill::verify
