// SPDX-License-Identifier: Apache-2.0
// A scan plan: where each view was taken, with what sensor, in which file. Pure values; reading YAML text is
// `document`.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "cloud/sensor.hpp"
#include "document/document.hpp"
#include "geom/pose.hpp"

namespace scanmill::plan {

struct Station {
  std::string name;
  Pose pose;                          // sensor (= view) frame to global frame, mm
  std::string data;                   // file of the view, relative to the plan; may be empty before the scan was made
  std::optional<std::string> sha256;  // expected content of `data`
};

struct ScanPlan {
  std::string name;
  double units_mm = 1;  // length of one unit of the data files in mm (poses are always mm)
  Sensor sensor;
  bool has_sensor = false;
  std::vector<Station> stations;
};

/// The plan of a parsed YAML tree (schemas/plan.schema.json). A pose is `matrix` (row-major 4x4, 16 numbers),
/// `quaternion: [x, y, z, w]` with `translation`, or `eye` with `target` (and `up`).
/// errors  BadParameter with "name:line:column"; all problems of the file in one message, a line each
Result<ScanPlan> plan_from(const document::Node& root, const std::string& name);

/// The same plan as a tree that plan_from reads back to the same bits (poses as matrices).
document::Node to_document(const ScanPlan& plan);

/// mm per unit for "mm", "cm", "m", "in", "um"; nothing for other words.
std::optional<double> unit_mm(std::string_view word);

}  // namespace scanmill::plan
