// SPDX-License-Identifier: Apache-2.0
// Reduction in parts, for clouds that are worked on by several processes: passes over pieces of the input, frames over
// bricks of the lattice, and their joining. Every part is a pure function, and the parts together give what
// reduce_cloud gives, to the last bit, however input and lattice are cut.
#pragma once
#include <span>
#include <vector>

#include "reduce/binning.hpp"
#include "reduce/frame.hpp"

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
/// All bins with the winners in force (of the second pass where there was one) and their frames to the reduced cloud.
Result<Reduction> join_parts(const LocalFrame& frame, BinTotals totals, Frames frames, const ReadCounts& counts,
                             const Levels& levels, const Params& params, const Context& context);

}  // namespace scanmill::reduce
