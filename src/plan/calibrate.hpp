// SPDX-License-Identifier: Apache-2.0
// Where the sensor sits on its mount and where axes are, from views of a sphere or a plane that stays on the deck.
#pragma once
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "plan/machine.hpp"
#include "plan/target_fit.hpp"

namespace scanmill::plan {

/// What one station saw.
struct TargetView {
  std::string station;
  std::vector<double> joints;  // one per joint, from counts
  std::vector<Vec3> points;    // sensor frame, mm
};

struct CalibrateParams {
  TargetKind kind = TargetKind::Sphere;
  std::optional<double> radius_mm;  // of the sphere, as certified; found when empty
  std::vector<std::size_t> axes;    // rotary joints whose place and zero are looked for as well
  double noise_mm = 0.025;
};

/// One number looked for: what it is now, how well these views tell it.
struct Unknown {
  std::string name;           // "mount x", "mount turn z", "axis b x", "zero b"
  std::string unit;           // mm or deg
  double value = 0;           // correction to what the plan says
  double deviation = 0;       // standard deviation, from noise and geometry
  bool is_determined = true;  // else these views do not tell it (apart from others), and it stayed as planned
};

struct CalibratedView {
  std::string station;
  std::size_t points = 0;              // on the target
  double before_mm = 0, after_mm = 0;  // rms distance of its points from the one target of all views
};

struct Calibration {
  Mount mount;                // with the offset that was found
  std::vector<Joint> joints;  // with origins and homes that were found
  Pose target;                // its centre or foot point; z along the plane's normal (global frame)
  double radius_mm = 0;
  double before_mm = 0, after_mm = 0;  // rms of all points
  std::vector<Unknown> unknowns;
  std::vector<CalibratedView> views;
  std::vector<std::string> without_target;  // stations where none was found
};

/// Levenberg-Marquardt over the mount's offset (six), the target (four or three) and the axes asked for (two across
/// each axis, and its zero), on up to 2,000 points of every view; what they leave
/// open by more than a tenth of a first guess (5 mm, 5 degrees; axes 2 mm, 2 degrees) stays as planned, one number
/// after the other. Fixed order, so the same bits for the same points. errors  BadParameter for a machine without
/// joints or an axis that is not rotary; BadInput when fewer than six stations
///         see the target
Result<Calibration> calibrate(const Machine& machine, const Mount& mount, std::span<const TargetView> views,
                              const CalibrateParams& params);

}  // namespace scanmill::plan
