// SPDX-License-Identifier: Apache-2.0
#include "optimise/near.hpp"

#include <bit>

namespace scanmill::optimise {
namespace {

/// The cut to float stays above the truth.
float rounded_up(double length2) { return static_cast<float>(std::sqrt(length2) * (1 + 0x1p-20)); }

}  // namespace

NearVertices::NearVertices(const Surface& surface, double longest_mm)
    : longest_(longest_mm), per_mm_(1 / longest_mm), place_(surface.vertex_count(), kNone) {
  Bounds box;
  std::vector<double> reach2(surface.vertex_count(), -1);  // stays so where no triangle is
  for (std::uint32_t t = 0; t < surface.slot_count(); ++t) {
    const auto& v = surface.slot(t).corner;
    const Vec3 a = surface.at(v[0]), b = surface.at(v[1]), c = surface.at(v[2]);
    const double ab = norm2(a - b), bc = norm2(b - c), ca = norm2(c - a);
    reach2[v[0]] = std::max({reach2[v[0]], ab, ca});
    reach2[v[1]] = std::max({reach2[v[1]], ab, bc});
    reach2[v[2]] = std::max({reach2[v[2]], bc, ca});
    for (const Vec3 p : {a, b, c}) box.add(p);
  }
  low_ = box.low;
  const Vec3 size = box.size();
  rounding_ = 0x1p-20 * std::max({size.x, size.y, size.z, longest_mm});
  buckets_.resize(std::bit_ceil(surface.vertex_count() / 2 + 16));
  mask_ = buckets_.size() - 1;
  std::vector<std::uint32_t> bucket(surface.vertex_count(), 0);
  for (std::uint32_t v = 0; v < bucket.size(); ++v) {
    if (reach2[v] < 0) continue;
    const Vec3 p = surface.at(v) - low_;
    bucket[v] =
        static_cast<std::uint32_t>((row_of(cell(p.y), cell(p.z)) + static_cast<std::uint64_t>(cell(p.x))) & mask_);
    ++buckets_[bucket[v]].end;
  }
  std::uint32_t count = 0;
  for (std::uint32_t v = 0; v < bucket.size(); ++v) {  // room for each bucket when its first vertex comes
    Bucket& own = buckets_[bucket[v]];
    if (reach2[v] < 0 || own.begin != 0 || own.end == 0) continue;
    own.begin = count + 1;  // one more than it is, so that 0 means none
    count += own.end;
    own.end = own.begin;
  }
  entries_.resize(count);
  reach_.resize(count);
  for (std::uint32_t v = 0; v < bucket.size(); ++v) {
    if (reach2[v] < 0) continue;
    const Vec3 p = surface.at(v) - low_;
    place_[v] = buckets_[bucket[v]].end++ - 1;
    entries_[place_[v]] = {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z), v};
    reach_[place_[v]] = rounded_up(reach2[v]);
  }
  for (Bucket& b : buckets_)
    if (b.begin != 0) b = {b.begin - 1, b.end - 1};
}

void NearVertices::reach_at_least(std::uint32_t v, double length2) {
  const float length = rounded_up(length2);
  std::atomic_ref reach(reach_[place_[v]]);
  float old = reach.load(std::memory_order_relaxed);
  while (old < length && !reach.compare_exchange_weak(old, length, std::memory_order_relaxed)) {
  }
}

}  // namespace scanmill::optimise
