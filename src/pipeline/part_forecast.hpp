// SPDX-License-Identifier: Apache-2.0
// What the parts of a cut scan will take, wave by wave, before the first of them is made.
#pragma once
#include <cstdint>
#include <vector>

#include "base/context.hpp"
#include "pipeline/cut_scan.hpp"

namespace scanmill::pipeline {

/// Of a cut cloud. A bin counts in every piece that has points in it.
struct BinCounts {
  std::uint64_t points = 0, of_pieces = 0, of_all = 0;
};
/// One pass. Of more than some millions of points a share of the bins is counted, within some per cent.
Result<BinCounts> count_bins(const PointSource& points, const What& what, const Cut& cut, const Context& context);

struct WaveForecast {
  /// Greatest sum of the parts that are there at one time; no less than they take.
  std::uint64_t disk = 0;
  double cpu = 0;  // of 1 for the whole scan
};
/// The count, then as scan_waves, then the scan itself with the files it writes.
std::vector<WaveForecast> forecast_waves(const Cut& cut, const What& what, const BinCounts& bins);

/// The counts are kept with the parts.
std::optional<BinCounts> kept_counts(const Cut& cut);
Result<void> keep_counts(const Cut& cut, const BinCounts& bins);

}  // namespace scanmill::pipeline
