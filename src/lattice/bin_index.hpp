// SPDX-License-Identifier: Apache-2.0
// The only map from bin to record: an OpenVDB Int32 tree whose values are slots into plain arrays. The wall around
// OpenVDB is bin_index.cpp; nothing of it shows here.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "lattice/lattice.hpp"

namespace scanmill {

/// Bin numbers relative to a base bin, so that they fit 32 bits wherever the cloud lies.
using LocalBin = std::array<std::int32_t, 3>;

inline constexpr std::int32_t kNoSlot = -1;

/// Map from local bins to slots, being filled. One per worker; not for concurrent use.
class BinTree {
 public:
  BinTree();
  ~BinTree();
  BinTree(BinTree&&) noexcept;
  BinTree& operator=(BinTree&&) noexcept;

  /// slots[n] = slot of bins[n]; a bin seen for the first time gets the next number, starting from size().
  /// Fast when neighbouring entries lie in the same 8x8x8 leaf.
  void slots_of(std::span<const LocalBin> bins, std::span<std::int32_t> slots);
  std::int32_t size() const;
  std::size_t memory_bytes() const;

  /// Every bin with its slot, in ascending key (Z-order of base + bin; base a multiple of 8 on each axis).
  struct Entry {
    LocalBin bin;
    std::int32_t slot;
  };
  std::vector<Entry> sorted(const BinKey& base) const;

 private:
  friend class BinIndex;
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Read-only index: local bin -> row, rows in ascending key. Any thread may ask.
class BinIndex {
 public:
  BinIndex();
  ~BinIndex();
  BinIndex(BinIndex&&) noexcept;
  BinIndex& operator=(BinIndex&&) noexcept;
  /// bins[row] in ascending key.
  static BinIndex over(std::span<const LocalBin> bins);

  std::size_t memory_bytes() const;

  /// Looks up windows of bins; remembers the leaves it met last. One per thread.
  class Reader {
   public:
    explicit Reader(const BinIndex& index);
    ~Reader();
    Reader(Reader&&) noexcept;
    /// Row of one bin, or kNoSlot.
    std::int32_t row_at(const LocalBin& bin);
    /// rows[n] = row of bins[n], or kNoSlot.
    void rows_of(std::span<const LocalBin> bins, std::span<std::int32_t> rows);
    /// Rows of the occupied bins in the (2 radius + 1)^3 window around `centre` (itself included), radius <= 8, in
    /// order of i, then j, then k (k runs fastest); appended to `rows`.
    void window(const LocalBin& centre, int radius, std::vector<std::int32_t>& rows);
    struct Neighbour {
      std::int32_t row;
      std::int8_t di, dj, dk;
    };
    void window(const LocalBin& centre, int radius, std::vector<Neighbour>& out);

    /// Rows of the occupied bins from `low` to `high` (both included, at most 8 apart on each axis), in the same order;
    /// appended.
    void box(const LocalBin& low, const LocalBin& high, std::vector<std::int32_t>& rows);

   private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
  };

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace scanmill
