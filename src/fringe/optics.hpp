// SPDX-License-Identifier: Apache-2.0
// Camera and projector of a fringe sensor (Bradley 2001, section 3.1: the phase of the object's fringes less that of a
// flat reference plate's gives the range).
//
//   camera o-----b-----o projector        Both look along +z from one height; the grating stands parallel to the plate,
//   so
//          |\          /                  that its lines lie evenly on the plate, `period` apart along x. A point P
//          seen at | \        /                   depth z is lit by the line that would meet the plate at |  \      /
//          X = b + x - b L / z, |   \  P /                     x being where its pixel sees the plate. The plate's own
//          picture gives x / period, |    \  /                      the object's X / period, and their difference t
//          (turns) the depth: |     \/                           z = L b / (b - t period).
//   L -----+-----x---X-------- plate
#pragma once
#include <cstdint>
#include <span>

#include "base/fields.hpp"
#include "geom/vec3.hpp"

namespace scanmill::fringe {

/// Lengths in one unit (mm unless a file says otherwise). The camera is a pinhole at the origin of the sensor frame;
/// its field is centred on the axis at the plate.
struct Optics {
  double field_x_mm = 50, field_y_mm = 50;
  double stand_off_mm = 150;  // of the reference plate
  double depth_mm = 15;       // half the depth band: points outside are no measurements
  double baseline_mm = 60;    // of the projector along +x
  static std::span<const Field> fields();

  /// Where pixel (column, row) of an image of this size sees the plate.
  Vec3 on_plate(std::int64_t column, std::int64_t row, std::int64_t width, std::int64_t height) const {
    return {((static_cast<double>(column) + 0.5) / static_cast<double>(width) - 0.5) * field_x_mm,
            ((static_cast<double>(row) + 0.5) / static_cast<double>(height) - 0.5) * field_y_mm, stand_off_mm};
  }
  /// Where the light through a point meets the plate, along x.
  double line_through(Vec3 p) const { return baseline_mm + (p.x - baseline_mm) * stand_off_mm / p.z; }
  /// Depth of a point whose line lies `shift` along x from where its pixel sees the plate.
  double depth_of(double shift) const { return stand_off_mm * baseline_mm / (baseline_mm - shift); }
};

}  // namespace scanmill::fringe
