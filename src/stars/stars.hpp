// SPDX-License-Identifier: Apache-2.0
// From reduced points to a two-manifold, consistently oriented set of triangles without crossings: local Delaunay
// stars, a vote, signs, and completion (docs/algorithm.md, "Stars" and "Complete").
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "base/context.hpp"
#include "base/progress.hpp"
#include "base/result.hpp"
#include "lattice/bin_index.hpp"
#include "mesh/limits.hpp"
#include "mesh/mesh.hpp"

namespace scanmill::stars {

/// Reduced points, one row per occupied bin in ascending key. Rows are vertex numbers here.
struct SurfacePoints {
  double edge_mm = 1;
  BinKey base;
  std::span<const LocalBin> bins;
  const BinIndex* index = nullptr;
  std::span<const Vec3> measured;   // exactly as they will be written (float32 values), mm
  std::span<const Vec3> projected;  // on the local plane, same frame: connectivity is computed on these
  std::span<const Vec3> normal;
  std::span<const std::uint8_t> sign_known;
  std::span<const std::uint8_t> kept;    // vertices to be
  std::span<const std::uint8_t> usable;  // thinned-out points that completion may still take (kept ones included)
};

struct Params {
  double range_bins = 2.5;   // g1
  double min_angle_deg = 5;  // g2
};

struct Report {
  std::uint64_t kept = 0;
  std::uint64_t confirmed = 0, candidates = 0, candidates_added = 0;
  std::uint64_t turned_back_sector = 0, turned_back_fold = 0, turned_back_crossing = 0;
  std::uint64_t loops_found = 0, loops_filled = 0, triangles_filled = 0, points_revived = 0;
  std::uint64_t repairs_tried = 0, repairs_kept = 0, peeled = 0, crossings_cut = 0;
  std::uint64_t open_edges = 0, unused_points = 0;
  RefusalCounts refused;  // star triangles refused by g1 and g2
};

struct Surface {
  std::vector<Triangle> triangles;       // rows; counter-clockwise seen from `normal`'s side; ascending
  std::vector<Vec3> normal;              // per row, signs made consistent
  std::vector<std::uint8_t> sign_known;  // per row: the side follows from views (through the component)
  Report report;
};

/// Mesh reduced points.
///
/// returns   triangles with 0 non-manifold edges and vertices, 0 mis-oriented edges, 0 crossing pairs, no edge above
///           range_bins h, no angle below min_angle_deg, whatever the input; gaps stay open
/// errors    BadParameter outside the limits of GrowthLimits; Cancelled
/// ties      weights hashed from bin keys for co-circular points; rows elsewhere
/// cost      about 3.5 us per kept point, one thread; 150 bytes, and as much again while crossings are sought; where
///           bins are finer than the points lie apart, up to 30 us per kept point
/// progress  stages "stars" and "complete", the latter with the loops of a round
/// source    Bradley 2001, 4.2 for the limits; stars, vote and completion are ours
Result<Surface> mesh_points(const SurfacePoints& points, const Params& params, const Context& context,
                            Progress& progress);
inline Result<Surface> mesh_points(const SurfacePoints& points, const Params& params, const Context& context) {
  NoProgress quiet;
  return mesh_points(points, params, context, quiet);
}

}  // namespace scanmill::stars
