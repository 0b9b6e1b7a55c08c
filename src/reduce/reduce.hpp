// SPDX-License-Identifier: Apache-2.0
// Voxel-bin reduction (Bradley 2001, section 4.1): of each bin's points keep one measured point, with what meshing
// needs to know about the surface around it.
#pragma once
#include <cstdint>
#include <vector>

#include "base/context.hpp"
#include "base/ids.hpp"
#include "base/result.hpp"
#include "cloud/cloud.hpp"
#include "lattice/bin_index.hpp"
#include "reduce/params.hpp"

namespace scanmill::reduce {

/// Why a bin's point is not a vertex candidate.
enum class Drop : std::uint8_t { Kept, TooFewPoints, Isolated, CentreDistance, NeighbourDistance };

/// One row per occupied bin, ascending bin key; all arrays have the same length.
struct ReducedCloud {
  Lattice lattice;
  BinKey base;  // bins are base + local
  std::vector<LocalBin> bins;
  std::vector<Vec3> measured;        // the kept point, global frame, mm, as measured (double)
  std::vector<SourceKey> source;     // where it came from
  std::vector<std::int64_t> counts;  // points in the bin
  std::vector<Drop> drop;
  // Frame of the bin: plane of the moments of the bins around it.
  std::vector<Vec3> projected;        // foot of `measured` on that plane; `measured` where the frame is not valid
  std::vector<Vec3> normal;           // unit; sign from views when sign_known, else arbitrary but fixed
  std::vector<float> residual;        // rms distance from the plane, bin edges
  std::vector<float> variation;       // least eigenvalue / trace, 0..1/3
  std::vector<float> plane_distance;  // of the bin's centre from the plane, bin edges, >= 0
  std::vector<std::uint8_t> frame_valid;
  std::vector<std::uint8_t> sign_known;
  BinIndex index;  // local bin -> row

  std::size_t size() const { return bins.size(); }
  BinKey key(std::size_t row) const { return {base.i + bins[row][0], base.j + bins[row][1], base.k + bins[row][2]}; }
};

struct Report {
  std::uint64_t points_read = 0;  // rows of all files
  std::uint64_t not_finite = 0, sensor_invalid = 0;
  std::uint64_t points_used = 0;  // binned
  std::uint64_t bins = 0;
  std::uint64_t dropped_too_few = 0, dropped_isolated = 0, dropped_centre_distance = 0, dropped_neighbour_distance = 0;
  std::uint64_t kept = 0;
  Bounds bounds;                  // of the binned points
  double median_residual = 0;     // bin edges
  double noise = 0;               // of the points about their surface, bin edges, without curvature
  std::int32_t frame_radius = 1;  // 1: frames from 3x3x3 bins; 2: from 5x5x5, chosen above 0.15 h of noise
  double bin_mm = 0;
  std::uint64_t index_bytes = 0;   // memory of the OpenVDB trees at their largest
  std::uint64_t record_bytes = 0;  // memory of the per-bin arrays
};

struct Reduction {
  ReducedCloud cloud;
  Report report;
};

/// Reduce a cloud on the job's lattice.
///
/// points    global frame, mm; read twice with representative = surface (and once more to find the bounds or a bin size
///           when the lattice asks for it)
/// returns   every occupied bin with its kept point, frame and drop reason, in ascending bin key
/// errors    BadParameter when the lattice has no size or several; BadInput when no finite point is there or the bins
///           would not fit 2^31 per axis; Cancelled; what `points` reports
/// ties      centre: least (squared distance to the bin's centre, x, y, z, source key); surface: least (|p-f|^2 +
///           3 ((p-f).n)^2 with f the centre's foot, x, y, z, source key)
/// cost      O(points); about 230 bytes per occupied bin at the peak
/// source    Bradley 2001, 4.1; the frame and the surface rule are ours (docs/algorithm.md)
Result<Reduction> reduce_cloud(const PointSource& points, const LatticeParams& lattice, const Params& params,
                               const Context& context);

}  // namespace scanmill::reduce
