// SPDX-License-Identifier: Apache-2.0
// Whether the points of a view can have been measured by the plan's sensor: depth band and field.
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "plan/stations.hpp"

namespace scanmill::plan {

struct BandCounts {
  std::uint64_t points = 0, too_near = 0, too_far = 0, beside = 0;
  double nearest_mm = 1e300, farthest_mm = -1e300;  // depth of all points
  double beside_mm = 0;                             // farthest beyond the border of the field
  void add(const BandCounts& other);
  friend bool operator==(const BandCounts&, const BandCounts&) = default;
};

/// Adds points given in the sensor frame, mm. The band is widened by four times the noise and the field by a pixel: a
/// point at the border is no fault.
void count_band(const Sensor& sensor, std::span<const Vec3> points, BandCounts& counts);

/// Above this share of a view's points outside, the view is not of this sensor or not of this place: an error. Less is
/// a warning.
inline constexpr double kMostOutside = 0.01;
std::vector<Finding> band_findings(const Sensor& sensor, const std::string& station, const BandCounts& counts);

}  // namespace scanmill::plan
