// SPDX-License-Identifier: Apache-2.0
// Large clouds block by block through space: what lies together is read together, so that a pass looks at little of
// what it fills at a time, in whatever order the views were taken.
#pragma once
#include <cstdint>
#include <vector>

#include "base/context.hpp"
#include "cloud/cloud.hpp"

namespace scanmill {

struct BlockOrder {
  std::vector<std::uint32_t> order;  // numbers of blocks
  Bounds bounds;                     // of all points
};

/// Numbers of all blocks along the Z-order curve of their middles; the first block stays the first, so that it means
/// the same to those who ask it for a place to start from. `look` sees every block too, on the worker that read it.
///
/// errors    what `points` reports; Cancelled
/// ties      by number
/// cost      one pass over the points
Result<BlockOrder> spatial_order(const PointSource& points, const Context& context,
                                 FunctionRef<void(int worker, const PointBlock& block)> look);

/// The same blocks under other numbers.
class OrderedPoints final : public PointSource {
 public:
  OrderedPoints(const PointSource& points, std::vector<std::uint32_t> order)
      : points_(points), order_(std::move(order)) {}
  std::size_t block_count() const override { return order_.size(); }
  Result<void> read_block(std::size_t number, PointBlock& out) const override {
    return points_.read_block(order_[number], out);
  }
  std::uint64_t expected_points() const override { return points_.expected_points(); }

 private:
  const PointSource& points_;
  std::vector<std::uint32_t> order_;
};

}  // namespace scanmill
