// SPDX-License-Identifier: Apache-2.0
// The local plane of every bin from the moments around it. Internal to `reduce`.
#pragma once
#include <vector>

#include "reduce/reduce.hpp"

namespace scanmill::reduce {

/// One row per bin.
struct Frames {
  std::vector<Vec3> centroid;  // global, mm: a point of the plane
  std::vector<Vec3> normal;
  std::vector<float> residual, variation, plane_distance;
  std::vector<std::uint8_t> valid, sign_known;
  double median_residual = 0;  // of the valid frames, bin edges
};

/// Planes through the weighted moments of the 3x3x3 bins around each bin (weight exp(-d^2/2) per step and axis).
/// A frame is valid with at least four occupied bins and a trace above 0.05 h^2.
/// cost  0.5 us per bin
Frames frames_of(const ReducedCloud& cloud, const std::vector<Moments>& moments, const Context& context);

/// c2: the greedy independent set of the candidates in the order (distance, key); a candidate within c2 h of a kept one in
/// the 5x5x5 window is dropped. Found by rounds in which a point decides once all better neighbours have: the same set as
/// the serial greedy walk, for any threads. Points of two sides of a thin wall (signs known, normals opposed) do not compete.
void thin(ReducedCloud& cloud, const std::vector<double>& order, double distance_bins, bool on_projected,
          const Context& context);

}  // namespace scanmill::reduce
