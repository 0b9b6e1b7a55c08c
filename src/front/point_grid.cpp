// SPDX-License-Identifier: Apache-2.0
#include "front/point_grid.hpp"

#include <algorithm>

namespace scanmill::front {
namespace {

/// Cells beyond this share the last one: neighbours stay neighbours, and the numbers stay integers.
constexpr double kMaxCell = 1e15;

std::int64_t cell_number(double offset, double cell_mm) {
  return static_cast<std::int64_t>(std::floor(std::clamp(offset / cell_mm, -kMaxCell, kMaxCell)));
}

}  // namespace

PointGrid::PointGrid(std::span<const Vec3> points, double radius) : points_(points), cell_mm_(radius * (1 + 1e-9)) {
  Bounds bounds;
  for (const Vec3 p : points) bounds.add(p);
  low_ = bounds.low;
  entries_.reserve(points.size());
  for (std::uint32_t row = 0; row < points.size(); ++row) entries_.push_back({cell_of(points[row]), row});
  std::sort(entries_.begin(), entries_.end(),
            [](const Entry& a, const Entry& b) { return a.cell != b.cell ? a.cell < b.cell : a.row < b.row; });
}

PointGrid::Cell PointGrid::cell_of(Vec3 p) const {
  return {cell_number(p.z - low_.z, cell_mm_), cell_number(p.y - low_.y, cell_mm_),
          cell_number(p.x - low_.x, cell_mm_)};
}

void PointGrid::each_within(Vec3 centre, double radius, FunctionRef<void(std::uint32_t)> body) const {
  const Cell middle = cell_of(centre);
  const double limit = radius * radius;
  for (std::int64_t z = middle[0] - 1; z <= middle[0] + 1; ++z)
    for (std::int64_t y = middle[1] - 1; y <= middle[1] + 1; ++y) {
      const Cell first{z, y, middle[2] - 1}, last{z, y, middle[2] + 1};
      auto entry = std::lower_bound(entries_.begin(), entries_.end(), first,
                                    [](const Entry& e, const Cell& cell) { return e.cell < cell; });
      for (; entry != entries_.end() && entry->cell <= last; ++entry)
        if (norm2(points_[entry->row] - centre) <= limit) body(entry->row);
    }
}

}  // namespace scanmill::front
