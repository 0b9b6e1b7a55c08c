// SPDX-License-Identifier: Apache-2.0
// Which vertices have triangles in reach of a place? Internal to `optimise`.
#pragma once
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
    Vec3 at;
    std::uint32_t vertex;
  };
  // Cells of a row along x lie in a row of buckets, so a query reads few stretches of memory. Different cells may share a
  // bucket; distances tell their vertices apart.
  std::uint64_t row_of(std::int64_t y, std::int64_t z) const {
    return (static_cast<std::uint64_t>(y) * 0x9e3779b97f4a7c15u ^ static_cast<std::uint64_t>(z) * 0xc2b2ae3d27d4eb4fu) >>
           20;
  }
  std::int64_t cell(double offset) const { return static_cast<std::int64_t>(offset * per_mm_); }

  Vec3 low_;
  double longest_ = 0, per_mm_ = 0;
  std::uint64_t mask_ = 0;
  std::vector<std::uint32_t> first_;
  std::vector<Entry> entries_;
  std::vector<float> reach_;  // mm, rounded up
};

template <class Visit>
bool NearVertices::any_near(const Bounds& box, const Visit& visit) const {
  const double wide = 0.5 * longest_;
  const Vec3 margin{wide, wide, wide}, low = box.low - margin, high = box.high + margin;
  const Vec3 from = low - low_, to = high - low_;
  const std::int64_t x0 = cell(from.x > 0 ? from.x : 0), x1 = cell(to.x), y1 = cell(to.y), z1 = cell(to.z);
  for (std::int64_t z = cell(from.z > 0 ? from.z : 0); z <= z1; ++z)
    for (std::int64_t y = cell(from.y > 0 ? from.y : 0); y <= y1; ++y) {
      const std::uint64_t row = row_of(y, z);
      for (std::int64_t x = x0; x <= x1; ++x) {
        const std::uint64_t bucket = (row + static_cast<std::uint64_t>(x)) & mask_;
        for (std::uint32_t i = first_[bucket]; i < first_[bucket + 1]; ++i) {
          const Entry& e = entries_[i];
          if (e.at.x < low.x || e.at.x > high.x || e.at.y < low.y || e.at.y > high.y || e.at.z < low.z ||
              e.at.z > high.z)
            continue;
          const double reach = static_cast<double>(reach_[e.vertex]), half = 0.5 * reach;
          if (e.at.x < box.low.x - half || e.at.x > box.high.x + half || e.at.y < box.low.y - half ||
              e.at.y > box.high.y + half || e.at.z < box.low.z - half || e.at.z > box.high.z + half)
            continue;
          if (visit(e.vertex, reach)) return true;
        }
      }
    }
  return false;
}

}  // namespace scanmill::optimise
