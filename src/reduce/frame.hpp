// SPDX-License-Identifier: Apache-2.0
// The local plane of every bin from the moments around it. Internal to `reduce`, and to reductions in
// parts (parts.hpp).
#pragma once
#include <vector>

#include "reduce/cells.hpp"
#include "reduce/reduce.hpp"

namespace scanmill::reduce {

/// One row per bin.
struct Frames {
  std::vector<Vec3> centroid;  // global, mm: a point of the plane
  std::vector<Vec3> normal;
  std::vector<float> residual, variation, plane_distance;
  std::vector<std::uint8_t> valid, sign_known;
  double median_residual = 0;  // of the valid frames, bin edges

  void resize(std::size_t count);
};

/// Of the valid frames; 0 when there is none.
double median_residual_of(const Frames& frames);

/// Planes through the weighted moments of the bins around each bin: 3x3x3 with weight exp(-d^2/2) per step and axis
/// (radius 1), or 5x5x5 with exp(-d^2/4.5) (radius 2). A frame is valid with at least four occupied bins and a trace
/// above 0.05 h^2.
/// cost  0.3 us per bin at radius 1, 1.2 us at radius 2
Frames frames_of(const ReducedCloud& cloud, const BinCells& cells, int radius, const Context& context);

/// Noise of the points about their surface, bin edges. Curvature grows with the window, noise does not: from the median
/// residuals of the same bins in both windows, about 4,096 chosen by key, the part that does not grow.
double noise_of(const ReducedCloud& cloud, const BinCells& cells, const Context& context);

}  // namespace scanmill::reduce
