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
  /// Two spacings; up to three where eight times the noise is more, since a part of the noise is curvature, which
  /// larger bins would only lose. At most an eighth of the largest extent.
  std::optional<double> suggested_bin_mm;
};

/// Reduces the cloud twice on trial lattices: once to see its area, once at about nine points per bin for the noise.
/// errors  those of reduce_cloud
Result<CloudMeasure> measure_cloud(const PointSource& points, const Context& context);

}  // namespace scanmill::pipeline
