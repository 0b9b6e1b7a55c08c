// SPDX-License-Identifier: Apache-2.0
// The ray behind every pixel of a sensor, in the sensor's frame.
#pragma once
#include "cloud/sensor.hpp"
#include "simulate/trace.hpp"

namespace scanmill::simulate {

/// Through the centre of the pixel, of the field at the stand-off; rows and columns from 0.
inline Ray ray_of_pixel(const Sensor& sensor, std::int64_t column, std::int64_t row) {
  const double nx = static_cast<double>(sensor.pixels_x), ny = static_cast<double>(sensor.pixels_y);
  const double x = ((static_cast<double>(column) + 0.5) / nx - 0.5) * sensor.field_x_mm;
  const double y = ((static_cast<double>(row) + 0.5) / ny - 0.5) * sensor.field_y_mm;
  if (!sensor.perspective) return {{x, y, 0}, {0, 0, 1}};
  return {{0, 0, 0}, unit({x, y, sensor.stand_off_mm})};
}

}  // namespace scanmill::simulate
