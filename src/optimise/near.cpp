// SPDX-License-Identifier: Apache-2.0
#include "optimise/near.hpp"

#include <bit>
#include <numeric>

namespace scanmill::optimise {

NearVertices::NearVertices(const Surface& surface, double longest_mm)
    : longest_(longest_mm), per_mm_(1 / longest_mm), reach_(surface.vertex_count(), 0) {
  Bounds box;
  for (std::uint32_t t = 0; t < surface.slot_count(); ++t) {
    const auto& v = surface.slot(t).corner;
    for (std::size_t e = 0; e < 3; ++e) {
      const double length2 = norm2(surface.at(v[e]) - surface.at(v[e == 2 ? 0 : e + 1]));
      reach_at_least(v[e], length2);
      reach_at_least(v[e == 2 ? 0 : e + 1], length2);
      box.add(surface.at(v[e]));
    }
  }
  low_ = box.low;
  const Vec3 size = box.size();
  rounding_ = 0x1p-20 * std::max({size.x, size.y, size.z, longest_mm});
  const std::size_t buckets = std::bit_ceil(surface.vertex_count() / 2 + 16);
  mask_ = buckets - 1;
  number_.assign(buckets, 0);
  first_.assign(3, 0);  // bucket 0 holds nothing
  auto bucket_of = [&](Vec3 p) {
    return (row_of(cell(p.y), cell(p.z)) + static_cast<std::uint64_t>(cell(p.x))) & mask_;
  };
  std::vector<std::uint32_t> number(surface.vertex_count(), 0);
  for (std::uint32_t v = 0; v < number.size(); ++v) {
    if (reach_[v] == 0) continue;  // in no triangle
    std::uint32_t& n = number_[bucket_of(surface.at(v) - low_)];
    if (n == 0) {
      n = static_cast<std::uint32_t>(first_.size() - 2);
      first_.push_back(0);
    }
    number[v] = n;
    ++first_[n + 2];
  }
  std::partial_sum(first_.begin(), first_.end(), first_.begin());
  entries_.resize(first_.back());
  for (std::uint32_t v = 0; v < number.size(); ++v) {
    if (number[v] == 0) continue;
    const Vec3 p = surface.at(v) - low_;
    entries_[first_[number[v] + 1]++] = {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z), v};
  }
}

void NearVertices::reach_at_least(std::uint32_t v, double length2) {
  const auto length = static_cast<float>(std::sqrt(length2) * (1 + 0x1p-20));  // the cut to float stays above the truth
  std::atomic_ref reach(reach_[v]);
  float old = reach.load(std::memory_order_relaxed);
  while (old < length && !reach.compare_exchange_weak(old, length, std::memory_order_relaxed)) {
  }
}

}  // namespace scanmill::optimise
