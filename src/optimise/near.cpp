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
  const std::size_t buckets = std::bit_ceil(surface.vertex_count() / 2 + 16);
  mask_ = buckets - 1;
  first_.assign(buckets + 2, 0);
  auto bucket_of = [&](std::uint32_t v) {
    const Vec3 p = surface.at(v) - low_;
    return (row_of(cell(p.y), cell(p.z)) + static_cast<std::uint64_t>(cell(p.x))) & mask_;
  };
  std::vector<std::uint32_t> bucket(surface.vertex_count());
  for (std::uint32_t v = 0; v < bucket.size(); ++v) {
    if (reach_[v] == 0) continue;  // in no triangle
    bucket[v] = static_cast<std::uint32_t>(bucket_of(v));
    ++first_[bucket[v] + 2];
  }
  std::partial_sum(first_.begin(), first_.end(), first_.begin());
  entries_.resize(first_.back());
  for (std::uint32_t v = 0; v < bucket.size(); ++v)
    if (reach_[v] != 0) entries_[first_[bucket[v] + 1]++] = {surface.at(v), v};
}

void NearVertices::reach_at_least(std::uint32_t v, double length2) {
  const auto length = static_cast<float>(std::sqrt(length2) * (1 + 0x1p-20));  // the cut to float stays above the truth
  std::atomic_ref reach(reach_[v]);
  float old = reach.load(std::memory_order_relaxed);
  while (old < length && !reach.compare_exchange_weak(old, length, std::memory_order_relaxed)) {
  }
}

}  // namespace scanmill::optimise
