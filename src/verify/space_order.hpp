// SPDX-License-Identifier: Apache-2.0
// Points in an order in which neighbours in the list are neighbours in space. Internal to `verify`.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "geom/vec3.hpp"

namespace scanmill::verify {

/// Puts rows of points along the Z-order curve of cells, at most 1024 along an axis. Keeps its memory between calls.
class SpaceOrder {
 public:
  /// Rows of `points` by cell, equal cells in the order given; cells of `edge` mm, or larger where 1024 would not do.
  /// Points of which three in four lie within 2 `edge` of the one before, as along scan lines, stay as they are: that
  /// order is as good, and free.
  /// points  finite, fewer than 2^32
  std::span<const std::uint32_t> of(std::span<const Vec3> points, double edge);

 private:
  void sort(std::span<const Vec3> points, double edge);
  struct Entry {
    std::uint32_t key, row;
  };
  std::vector<Entry> entries_, spare_;
  std::vector<std::uint32_t> rows_;
};

}  // namespace scanmill::verify
