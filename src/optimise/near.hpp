// SPDX-License-Identifier: Apache-2.0
// Which vertices have triangles in reach of a place? Internal to `optimise`.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "optimise/surface.hpp"

namespace scanmill::optimise {

/// Vertices never move, so the cells are made once; what changes is how far a vertex's edges reach.
class NearVertices {
 public:
  /// longest_mm: no edge will ever be longer.
  NearVertices(const Surface& surface, double longest_mm);

  /// The vertex has an edge of this squared length now. From any thread; a maximum, so the order does not matter.
  void reach_at_least(std::uint32_t v, double length2);

  /// visit(v, reach) for every vertex within half its reach of the box (an edge that meets the box ends at one of them,
  /// and a few others), until it returns true. May visit a vertex twice.
  template <class Visit>
  bool any_near(const Bounds& box, const Visit& visit) const;

 private:
  struct Entry {
    float x, y, z;  // from low_
    std::uint32_t vertex;
  };
  // Rows of cells along x fall on rows of buckets. Different cells may share a bucket; distances tell their vertices
  // apart. Entries lie in the order in which the buckets' first vertices come: what is near in the mesh is near in
  // memory.
  std::uint64_t row_of(std::int64_t y, std::int64_t z) const {
    return (static_cast<std::uint64_t>(y) * 0x9e3779b97f4a7c15u ^
            static_cast<std::uint64_t>(z) * 0xc2b2ae3d27d4eb4fu) >>
           20;
  }
  std::int64_t cell(double offset) const { return static_cast<std::int64_t>(offset * per_mm_); }

  Vec3 low_;
  double longest_ = 0, per_mm_ = 0, rounding_ = 0;
  std::uint64_t mask_ = 0;
  struct Bucket {
    std::uint32_t begin = 0, end = 0;  // into entries_ and reach_
  };
  std::vector<Bucket> buckets_;
  std::vector<Entry> entries_;
  std::vector<float> reach_;          // per entry, mm, rounded up
  std::vector<std::uint32_t> place_;  // per vertex: its entry
};

template <class Visit>
bool NearVertices::any_near(const Bounds& box, const Visit& visit) const {
  const double wide = 0.5 * longest_ + rounding_;
  const Vec3 middle = (box.low + box.high) * 0.5 - low_, half = (box.high - box.low) * 0.5;
  const auto x = static_cast<float>(middle.x), y = static_cast<float>(middle.y), z = static_cast<float>(middle.z);
  const auto dx = static_cast<float>(half.x + rounding_), dy = static_cast<float>(half.y + rounding_),
             dz = static_cast<float>(half.z + rounding_);
  auto first_cell = [&](double m, double h) { return m - h > wide ? cell(m - h - wide) : 0; };
  const std::int64_t x0 = first_cell(middle.x, half.x), x1 = cell(middle.x + half.x + wide);
  const std::int64_t y0 = first_cell(middle.y, half.y), y1 = cell(middle.y + half.y + wide);
  const std::int64_t z0 = first_cell(middle.z, half.z), z1 = cell(middle.z + half.z + wide);
  const auto most = static_cast<float>(wide);
  for (std::int64_t k = z0; k <= z1; ++k)
    for (std::int64_t j = y0; j <= y1; ++j) {
      const std::uint64_t row = row_of(j, k);
      for (std::int64_t i = x0; i <= x1; ++i) {
        const Bucket bucket = buckets_[(row + static_cast<std::uint64_t>(i)) & mask_];
        for (std::uint32_t at = bucket.begin; at < bucket.end; ++at) {
          const Entry& e = entries_[at];
          const float apart = std::max({std::abs(e.x - x) - dx, std::abs(e.y - y) - dy, std::abs(e.z - z) - dz});
          if (apart > most || apart > 0.5f * reach_[at]) continue;
          if (visit(e.vertex, static_cast<double>(reach_[at]))) return true;
        }
      }
    }
  return false;
}

}  // namespace scanmill::optimise
