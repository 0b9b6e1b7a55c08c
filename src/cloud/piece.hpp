// SPDX-License-Identifier: Apache-2.0
// A part of a cloud, for a task that passes over no more of it.
#pragma once
#include <cstdint>

#include "cloud/cloud.hpp"

namespace scanmill {

/// The blocks of one of so many pieces of about the same number of blocks.
class PiecePoints final : public PointSource {
 public:
  PiecePoints(const PointSource& points, std::uint32_t number, std::uint32_t pieces) : points_(points) {
    const std::size_t all = points.block_count();
    first_ = all * number / pieces;
    last_ = all * (number + 1) / pieces;
  }
  std::size_t block_count() const override { return last_ - first_; }
  Result<void> read_block(std::size_t number, PointBlock& out) const override {
    return points_.read_block(first_ + number, out);
  }
  std::uint64_t expected_points() const override {
    const std::size_t all = points_.block_count();
    return all == 0 ? 0 : points_.expected_points() / all * block_count();
  }

 private:
  const PointSource& points_;
  std::size_t first_ = 0, last_ = 0;
};

}  // namespace scanmill
