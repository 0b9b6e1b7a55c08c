// SPDX-License-Identifier: Apache-2.0
// Points within a radius, from a uniform grid kept as one sorted array.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "base/context.hpp"
#include "geom/vec3.hpp"

namespace scanmill::front {

class PointGrid {
 public:
  /// All points finite; radius > 0 is the largest that will be asked for.
  PointGrid(std::span<const Vec3> points, double radius);

  /// body(row) for every point within `radius` (inclusive) of `centre`; cell by cell, ascending rows within a cell.
  void each_within(Vec3 centre, double radius, FunctionRef<void(std::uint32_t row)> body) const;

 private:
  using Cell = std::array<std::int64_t, 3>;  // z, y, x: a run of x neighbours is one run of the array
  struct Entry {
    Cell cell;
    std::uint32_t row;
  };
  Cell cell_of(Vec3 p) const;

  std::span<const Vec3> points_;
  Vec3 low_;
  double cell_mm_;
  std::vector<Entry> entries_;  // ascending (cell, row)
};

}  // namespace scanmill::front
