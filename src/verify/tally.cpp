// SPDX-License-Identifier: Apache-2.0
#include "verify/tally.hpp"

#include <algorithm>
#include <cmath>

namespace scanmill::verify {

void Ranks::open(std::size_t page) {
  if (page >= pages_.size()) pages_.resize(page + 1);
  if (!pages_[page]) pages_[page] = std::make_unique<std::array<std::uint64_t, kPage>>();
}

void Ranks::add(const Ranks& other) {
  for (std::size_t page = 0; page < other.pages_.size(); ++page) {
    if (!other.pages_[page]) continue;
    open(page);
    for (std::size_t i = 0; i < kPage; ++i) (*pages_[page])[i] += (*other.pages_[page])[i];
  }
}

double Ranks::middle_of(std::size_t bucket) {
  constexpr std::size_t kLinear = std::size_t{1} << 20;
  if (bucket < kLinear) return 4 * static_cast<double>(bucket) + 1.5;
  const std::size_t octave = (bucket - kLinear) >> 19, within = (bucket - kLinear) & ((1u << 19) - 1);
  const auto width = static_cast<double>(std::uint64_t{8} << octave);
  return (static_cast<double>((1u << 19) + within) + 0.5) * width - 0.5;
}

double Ranks::at_rank(std::uint64_t rank) const {
  for (std::size_t page = 0; page < pages_.size(); ++page) {
    if (!pages_[page]) continue;
    for (std::size_t i = 0; i < kPage; ++i) {
      const std::uint64_t here = (*pages_[page])[i];
      if (rank < here) return middle_of(page * kPage + i);
      rank -= here;
    }
  }
  return 0;
}

void Sums::add(const Sums& other) {
  count += other.count;
  signed_sum += other.signed_sum;
  sum += other.sum;
  sum2 += other.sum2;
  above = std::max(above, other.above);
  below = std::max(below, other.below);
}

DistanceFigures figures_of(const Sums& sums, const Ranks* ranks, double bin_mm) {
  DistanceFigures figures;
  figures.count = sums.count;
  figures.above_mm = sums.above;
  figures.below_mm = sums.below;
  figures.max_mm = std::max(sums.above, sums.below);
  if (sums.count == 0) return figures;
  const auto n = static_cast<double>(sums.count);
  const double unit = bin_mm / kUnitsPerBin;
  // Rounding to units may not lift a mean above the greatest distance.
  auto within = [&](double value) { return std::min(value, figures.max_mm); };
  figures.mean_mm = within(static_cast<double>(sums.sum) / n * unit);
  figures.signed_mean_mm = std::clamp(static_cast<double>(sums.signed_sum) / n * unit, -figures.max_mm, figures.max_mm);
  figures.rms_mm = within(std::sqrt(static_cast<double>(sums.sum2) / n) * unit);
  if (ranks == nullptr) return figures;
  auto percentile = [&](std::uint64_t per_mille) {  // rank floor(q (n - 1)) without rounding of q n
    const WideCount rank = static_cast<WideCount>(sums.count - 1) * per_mille / 1000;
    return within(ranks->at_rank(static_cast<std::uint64_t>(rank)) * unit);
  };
  figures.percentiles =
      Percentiles{percentile(500), percentile(900), percentile(950), percentile(990), percentile(999)};
  return figures;
}

void Worst::add(const WorstPoint& point) {
  auto worse = [](const WorstPoint& a, const WorstPoint& b) {
    if (a.distance_mm != b.distance_mm) return a.distance_mm > b.distance_mm;
    if (a.source != b.source) return a.source < b.source;
    return before(a.place, b.place);
  };
  list_.insert(std::upper_bound(list_.begin(), list_.end(), point, worse), point);
  if (list_.size() > kListed) list_.pop_back();
}

}  // namespace scanmill::verify
