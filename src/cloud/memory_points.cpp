// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "cloud/cloud.hpp"

namespace scanmill {

MemoryPoints::MemoryPoints(std::vector<Vec3> positions, ViewPoint view_point, std::size_t block_size)
    : positions_(std::move(positions)), view_point_(view_point), block_size_(block_size) {}

std::size_t MemoryPoints::block_count() const { return (positions_.size() + block_size_ - 1) / block_size_; }

Result<void> MemoryPoints::read_block(std::size_t number, PointBlock& out) const {
  out.clear();
  out.view = ViewId{0};
  out.view_point = view_point_;
  const std::size_t begin = number * block_size_, end = std::min(positions_.size(), begin + block_size_);
  for (std::size_t i = begin; i < end; ++i) {
    ++out.points_read;
    if (!is_finite(positions_[i])) {
      ++out.not_finite;
      continue;
    }
    out.positions.push_back(positions_[i]);
    out.rows.push_back(i);
  }
  return {};
}

}  // namespace scanmill
