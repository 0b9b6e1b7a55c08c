// SPDX-License-Identifier: Apache-2.0
// Hand-made reduced points for the stars: bins, frames and index without the reduction.
#pragma once
#include <algorithm>
#include <numeric>
#include <vector>

#include "stars/stars.hpp"

namespace scanmill::stars {

class HandMade {
 public:
  /// One point per bin of edge 1 mm; rows follow the bins' keys, `row_of` tells where a point went.
  HandMade(std::vector<Vec3> points, std::vector<Vec3> normals) {
    std::vector<BinKey> keys;
    for (const Vec3 p : points) keys.push_back(bin_of(Lattice{}, p));
    std::vector<std::uint32_t> order(points.size());
    std::iota(order.begin(), order.end(), 0u);
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return before(keys[a], keys[b]); });
    row_of.resize(points.size());
    for (const std::uint32_t p : order) {
      row_of[p] = static_cast<std::uint32_t>(at.size());
      at.push_back(points[p]);
      normal.push_back(unit(normals[p]));
      bins.push_back({static_cast<std::int32_t>(keys[p].i), static_cast<std::int32_t>(keys[p].j),
                      static_cast<std::int32_t>(keys[p].k)});
    }
    sign_known.assign(at.size(), 0);
    kept.assign(at.size(), 1);
    index = BinIndex::over(bins);
  }
  explicit HandMade(const std::vector<Vec3>& points) : HandMade(points, std::vector<Vec3>(points.size(), {0, 0, 1})) {}

  SurfacePoints points() const { return {1, {}, bins, &index, at, at, normal, sign_known, kept, kept}; }

  std::vector<Vec3> at, normal;
  std::vector<std::uint8_t> sign_known, kept;
  std::vector<std::uint32_t> row_of;

 private:
  std::vector<LocalBin> bins;
  BinIndex index;
};

}  // namespace scanmill::stars
