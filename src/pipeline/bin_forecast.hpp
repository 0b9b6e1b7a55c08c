// SPDX-License-Identifier: Apache-2.0
// How many bins a cloud will fill, and what its stages will want of memory and disk, before any of them begins.
#pragma once
#include <cstdint>
#include <vector>

#include "lattice/bin_index.hpp"
#include "reduce/binning.hpp"

namespace scanmill::pipeline {

/// Counts occupied bins in one leaf of 8x8x8 of so many, chosen by a hash of its place: every part of the cloud has its
/// share.
class BinForecast {
 public:
  BinForecast(const reduce::LocalFrame& frame, int workers, int one_in = 64);
  /// May be called by several workers at once.
  void look(int worker, const PointBlock& block);
  /// Occupied bins of the points seen, within some per cent from a million on. No worker may be at work.
  std::uint64_t bins();
  /// Those of another part of the cloud, counted in the same leaves.
  void add(BinForecast& other);

  /// Bytes of memory that a bin takes at the peak of a scan, all stages and pictures; measured at 16 million.
  static constexpr std::uint64_t kBytesPerBin = 640;

 private:
  struct Part {
    BinTree tree;
    std::vector<LocalBin> bins;
    std::vector<std::int32_t> slots;
  };
  void take(Part& from);

  reduce::LocalFrame frame_;
  std::uint64_t one_in_;
  std::vector<Part> parts_;
};

}  // namespace scanmill::pipeline
