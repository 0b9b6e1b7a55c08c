// SPDX-License-Identifier: Apache-2.0
#include "cloud/sensor.hpp"

namespace scanmill {

std::span<const Field> Sensor::fields() {
  static const Field kTable[] = {
      field<Sensor, &Sensor::pixels_x>("pixels_x", "", "Pixels along x.", {1, 20000}),
      field<Sensor, &Sensor::pixels_y>("pixels_y", "", "Pixels along y.", {1, 20000}),
      field<Sensor, &Sensor::field_x_mm>("field_x_mm", "", "Width of the field at the stand-off.", {0, 1e6, true}),
      field<Sensor, &Sensor::field_y_mm>("field_y_mm", "", "Height of the field at the stand-off.", {0, 1e6, true}),
      field<Sensor, &Sensor::stand_off_mm>(
          "stand_off_mm", "", "Distance from the sensor's reference point to the middle of the depth band.",
          {0, 1e6, true}),
      field<Sensor, &Sensor::depth_mm>("depth_mm", "", "Half the depth band about the stand-off.", {0, 1e6, true}),
      field<Sensor, &Sensor::noise_mm>("noise_mm", "", "Standard deviation of a range value.", {0, 1e6}),
      field<Sensor, &Sensor::max_incidence_deg>(
          "max_incidence_deg", "", "Angle between ray and surface normal beyond which nothing returns.", {0, 90}),
      field<Sensor, &Sensor::perspective>("perspective", "",
                                          "Rays leave the reference point (true) or are parallel (false)."),
  };
  return kTable;
}

}  // namespace scanmill
