// SPDX-License-Identifier: Apache-2.0
// A scan plan: the machine, its sensor, and where each view was taken, in which file. Pure values; reading YAML text is
// `document`.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "cloud/sensor.hpp"
#include "document/document.hpp"
#include "geom/pose.hpp"
#include "plan/machine.hpp"

namespace scanmill::plan {

/// A place of the part's surface to be looked at along its normal.
struct Target {
  Vec3 point, normal;                  // global frame; the normal is a unit vector after reading
  std::optional<double> stand_off_mm;  // the sensor's own unless given
};

/// Where a view was or is to be taken. Of what is given, counts go before joints, joints before pose, pose before
/// target.
struct Station {
  std::string name;
  Pose pose;                          // sensor (= view) frame to global frame, mm: what the points are placed with
  std::string data;                   // file of the view, relative to the plan; may be empty before the scan was made
  std::optional<std::string> sha256;  // expected content of `data`
  std::optional<std::vector<double>> joints;        // as commanded, one per joint of the machine
  std::optional<std::vector<std::int64_t>> counts;  // as recorded, one per joint; joints that are not counted: 0
  std::optional<Pose> given_pose;
  std::optional<Target> target;
  bool via = false;  // a place to pass, no view is taken
};

/// Of depth maps: pinhole in pixels, and pixel values per unit of length.
struct Camera {
  double fx = 0, fy = 0, cx = 0, cy = 0, depth_scale = 1000;
};

struct ScanPlan {
  std::string name;
  double units_mm = 1;           // length of one unit of the data files in mm (poses are always mm)
  bool left_handed = false;      // the data files' z is negated on reading: their frames are left-handed
  std::optional<Camera> camera;  // the data files are depth maps
  std::optional<Machine> machine;
  Sensor sensor;
  bool has_sensor = false;
  Mount mount;
  std::optional<Box> part;  // where the part is, global frame
  std::vector<Station> stations;
};

/// The plan of a parsed YAML tree (schemas/plan.schema.json). A pose is `matrix` (row-major 4x4, 16 numbers),
/// `quaternion: [x, y, z, w]` with `translation`, `rotation_deg: [rx, ry, rz]` with `translation`, or `eye` with
/// `target` (and `up`). Every station's pose is worked out: from counts or joints through the machine, from the pose
/// given, or from the target.
/// errors  BadParameter with "name:line:column"; all problems of the file in one message, a line each
Result<ScanPlan> plan_from(const document::Node& root, const std::string& name);

/// The same plan as a tree that plan_from reads back to the same bits (poses as matrices).
document::Node to_document(const ScanPlan& plan);

/// mm per unit for "mm", "cm", "m", "in", "um"; nothing for other words.
std::optional<double> unit_mm(std::string_view word);

}  // namespace scanmill::plan
