// SPDX-License-Identifier: Apache-2.0
// Reduction in parts, for clouds that are worked on by several processes: passes over pieces of the input, frames and
// thinning over bricks of the lattice, and their joining. Every part is a pure function, and the parts together give
// what reduce_cloud gives, to the last bit, however input and lattice are cut.
#pragma once
#include <span>
#include <vector>

#include "reduce/binning.hpp"
#include "reduce/frame.hpp"
#include "reduce/thin.hpp"

namespace scanmill::reduce {

/// Bins around a brick whose totals its frames look at.
inline constexpr std::int32_t kFrameHalo = 2;

/// What all frames share.
struct Levels {
  double noise = 0;               // bin edges
  std::int32_t frame_radius = 1;  // of the windows
};

/// The lattice is given by the job alone: edge and absolute origin. Others look at all points first.
bool is_cuttable(const LatticeParams& lattice);
/// errors  those of reduce_cloud before its first pass
Result<LocalFrame> frame_of_parts(const PointSource& points, const LatticeParams& lattice, const Params& params);
/// From the totals of all bins, ascending keys.
Levels levels_of_parts(const LocalFrame& frame, std::vector<LocalBin> bins, const BinCells& cells,
                       const Context& context);
/// Frames of some bins, ascending keys; good for those whose kFrameHalo neighbours in the cloud are all among them.
Frames frames_of_parts(const LocalFrame& frame, std::vector<LocalBin> bins, const BinCells& cells, std::int32_t radius,
                       const Context& context);
/// What the second pass measures against; `median_residual` of all frames.
std::vector<Target> targets_of(const LocalFrame& frame, std::span<const LocalBin> bins, const Frames& frames,
                               double median_residual, const Params& params);
/// Bins with the winners in force (of the second pass where there was one) and their frames, any run of them: their
/// points before thinning. The index is not filled.
ReducedCloud points_of_parts(const LocalFrame& frame, BinTotals totals, Frames frames, const Params& params,
                             const Context& context);
/// Drops points of a part that has its index for others too near. `seen`: per row, that all occupied bins within
/// kThinReach of its own are in the part; empty where the part is the whole.
/// returns   per row 1 where points beyond the part could decide; those stay kept here. Empty for the whole.
std::vector<std::uint8_t> thin_part(ReducedCloud& part, const std::vector<std::uint8_t>& seen, const Params& params,
                                    const Context& context);
/// All rows, thinned, with what is known of them.
/// errors  BadInput beyond the numbers of rows
Result<Reduction> join_parts(ReducedCloud cloud, const ReadCounts& counts, const Levels& levels,
                             double median_residual);

}  // namespace scanmill::reduce
