// SPDX-License-Identifier: Apache-2.0
// What a LinuxCNC INI file says about the limits of a machine.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "base/bytes.hpp"

namespace scanmill::formats {

/// In mm and degrees, whatever the file's units are.
struct CncJoint {
  char letter = 'X';  // of the coordinate: X Y Z A B C U V W
  bool angular = false;
  std::optional<double> low, high, velocity, acceleration;
  std::optional<double> counts_per_unit;  // per mm or degree; without sign
  double backlash = 0, home = 0;
};

struct CncMachine {
  std::string name;
  std::vector<CncJoint> joints;    // in the order of the coordinates
  std::vector<std::string> notes;  // what was assumed or passed over
};

/// Sections [JOINT_n] (newer) or [AXIS_n] and [AXIS_letter] (older): TYPE, MIN_LIMIT, MAX_LIMIT, MAX_VELOCITY,
/// MAX_ACCELERATION, BACKLASH, HOME, SCALE (ENCODER_SCALE or INPUT_SCALE before STEP_SCALE or SCALE); [TRAJ]
/// COORDINATES and LINEAR_UNITS; [KINS] KINEMATICS with coordinates=; [EMC] MACHINE. Comments begin with # or ;.
/// errors  BadInput with "file:line": a line that is no section, comment or KEY = VALUE; a value that is no number; low
///         limit above the high one; no joint at all
Result<CncMachine> read_linuxcnc(const ByteSource& source);

}  // namespace scanmill::formats
