// SPDX-License-Identifier: Apache-2.0
// What the first pass gathers per bin. Internal to `reduce`, and to reductions in parts (parts.hpp).
#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "base/large_pages.hpp"
#include "cloud/cloud.hpp"
#include "reduce/placing.hpp"

namespace scanmill::reduce {

/// The point a bin keeps so far; ordered by (score, x, y, z, source).
struct Winner {
  double score = 1e300;
  Vec3 position;
  SourceKey source;
};
bool better(const Winner& a, const Winner& b);

/// Two cache lines per bin: the point nearest its centre, and the sums over its points.
struct alignas(64) Cell {
  double score = 1e300;
  Vec3 position;
  std::uint64_t row = 0;
  ViewId view{};
  WholeSums sums;

  Winner winner() const { return {score, position, {view, row}}; }
  void keep_better(const Winner& candidate) {
    if (candidate.score > score || (candidate.score == score && !better(candidate, winner()))) return;
    score = candidate.score;
    position = candidate.position;
    row = candidate.source.row;
    view = candidate.source.view;
  }
};

/// Unit vectors towards the sensor, summed, in units of 2^-20.
using Direction = std::array<std::int64_t, 3>;

/// An array that grows where it stands: nothing moves, and nothing is ever held twice.
template <class T>
class Blocks {
 public:
  static constexpr std::size_t kBlock = std::size_t{1} << 16;

  std::size_t size() const { return size_; }
  T& operator[](std::size_t n) { return begins_[n / kBlock][n % kBlock]; }
  const T& operator[](std::size_t n) const { return begins_[n / kBlock][n % kBlock]; }
  /// To `count` values at least.
  void grow(std::size_t count) {
    while (size_ < count) {
      if (size_ == blocks_.size() * kBlock) {
        reserve_large(blocks_.emplace_back(), kBlock);
        begins_.push_back(blocks_.back().data());
      }
      const std::size_t before = (blocks_.size() - 1) * kBlock;
      blocks_.back().resize(std::min(kBlock, count - before));
      size_ = before + blocks_.back().size();
    }
  }
  /// Takes the values of another, without moving them; value n stands at n + the returned place.
  std::size_t take(Blocks other) {
    const std::size_t place = blocks_.size() * kBlock;
    if (other.size_ == 0) return place;
    for (std::vector<T>& block : other.blocks_) blocks_.push_back(std::move(block));
    begins_.insert(begins_.end(), other.begins_.begin(), other.begins_.end());
    size_ = place + other.size_;
    return place;
  }

 private:
  std::vector<std::vector<T>> blocks_;
  std::vector<T*> begins_;  // of the blocks
  std::size_t size_ = 0;
};

/// Cells by row: rows in ascending key, cells wherever the pass met their bins.
struct BinCells {
  Blocks<Cell> cells;
  Blocks<Direction> directions;   // of the cells; none while no view tells
  std::vector<std::uint32_t> at;  // the cell of a row; 2^32 cells would be 512 GiB

  std::size_t size() const { return at.size(); }
  const Cell& operator[](std::size_t row) const { return cells[at[row]]; }
  Cell& operator[](std::size_t row) { return cells[at[row]]; }
  Direction direction(std::size_t row) const { return directions.size() > 0 ? directions[at[row]] : Direction{}; }
  void push_back(const Cell& cell, const Direction& direction) {
    const std::size_t place = cells.size();
    at.push_back(static_cast<std::uint32_t>(place));
    cells.grow(place + 1);
    cells[place] = cell;
    if (directions.size() == 0 && direction == Direction{}) return;
    directions.grow(place + 1);
    directions[place] = direction;
  }
};

}  // namespace scanmill::reduce
