// SPDX-License-Identifier: Apache-2.0
// What a cloud tells about itself: how dense and how noisy it is, and which bins would suit it.
#pragma once
#include <cstdint>
#include <optional>

#include "base/context.hpp"
#include "base/result.hpp"
#include "cloud/cloud.hpp"

namespace scanmill::pipeline {

struct CloudMeasure {
  std::uint64_t points_read = 0, points_used = 0;
  Bounds bounds;  // mm
  // Nothing with fewer than 100 points, no noise with fewer than 1,000: too few to tell.
  std::optional<double> spacing_mm;  // square root of the area per point
  std::optional<double> noise_mm;    // rms distance from local planes: curvature and misregistration are in it
  /// The distance at least doubles with the scale: it comes of curvature and creases rather than of noise.
  bool shape_prevails = false;
  /// Two spacings; up to three where eight times the noise is more and shape does not prevail, since larger bins would
  /// only lose the shape. At most an eighth of the largest extent.
  std::optional<double> suggested_bin_mm;
};

/// Reduces the cloud on trial lattices: once to see its area, once at about nine points per bin for the noise, and
/// where there is noise that matters once more at twice the scale. errors  those of reduce_cloud
Result<CloudMeasure> measure_cloud(const PointSource& points, const Context& context);

}  // namespace scanmill::pipeline
