// SPDX-License-Identifier: Apache-2.0
// A range sensor as the paper describes it (section 3.1): one z per pixel of a flat field at a stand-off.
#pragma once
#include <span>

#include "base/fields.hpp"

namespace scanmill {

/// Sensor frame: +z is the viewing direction, away from the sensor; +x and +y along the pixel rows and columns; the
/// origin is the sensor's reference point. The field is centred on the axis at z = stand_off_mm; depths
/// from stand_off - depth to stand_off + depth are measured. Rays are parallel to z unless `perspective` is set (then
/// they leave the origin). Defaults are the paper's.
struct Sensor {
  std::int64_t pixels_x = 700, pixels_y = 500;
  double field_x_mm = 50, field_y_mm = 50;
  double stand_off_mm = 150;
  double depth_mm = 15;           // half the depth band
  double noise_mm = 0.025;        // standard deviation along the ray
  double max_incidence_deg = 75;  // steeper surface returns nothing
  bool perspective = true;
  static std::span<const Field> fields();
};

}  // namespace scanmill
