// SPDX-License-Identifier: Apache-2.0
// Reduction again, by the definitions in reduce.hpp alone: maps keyed by bin, serial walks, no tree and no threads.
#pragma once
#include <map>
#include <vector>

#include "clouds.hpp"
#include "reduce/frame.hpp"

namespace scanmill::reduce {

struct KeyOrder {
  bool operator()(const BinKey& a, const BinKey& b) const { return before(a, b); }
};

/// Sums over the points of one bin, about its centre, in units of h/1024; exact, so any order of points gives the same.
struct Moments {
  std::int64_t count = 0;
  std::int64_t sum[3] = {};
  std::int64_t product[6] = {};         // xx xy xz yy yz zz
  std::int64_t view_direction[3] = {};  // summed unit vectors towards the sensor, 2^-20 units; zero when not known
};

/// One bin with all its points.
struct OracleBin {
  std::vector<Sample> samples;
  Moments moments;
  std::size_t row = 0;
};

using OracleBins = std::map<BinKey, OracleBin, KeyOrder>;

/// Every point in its bin; moments summed point by point; rows counted in key order.
OracleBins oracle_bins(const TestCloud& cloud, const Lattice& lattice);
/// The point with the least (squared distance to the centre, x, y, z, source).
Sample nearest_to_centre(const OracleBin& bin, const Lattice& lattice);
/// The point with the least (|p-f|^2 + 3 ((p-f).n)^2, x, y, z, source), or farthest from the plane when `crease`.
Sample nearest_to_foot(const OracleBin& bin, Vec3 foot, Vec3 normal, bool crease);
/// Drop reasons for the arrays of `cloud` (its `drop` is not read): the serial walk in order of (distance, key).
std::vector<Drop> oracle_drops(const ReducedCloud& cloud, const OracleBins& bins, const Params& params);

/// Least eigenvalue, trace, normal of the weighted moments of the 27 bins around `key`, by Eigen's solver.
struct OraclePlane {
  Vec3 normal, centroid;
  double least = 0, trace = 0, gap = 0;
  int bins = 0;
};
OraclePlane oracle_plane(const OracleBins& bins, const Lattice& lattice, const BinKey& key, int radius);

}  // namespace scanmill::reduce
