// SPDX-License-Identifier: Apache-2.0
// One scan of an archive: its files and how they lie to each other.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "cloud/cloud.hpp"
#include "cloud/sensor.hpp"
#include "formats/view_reader.hpp"
#include "geom/pose.hpp"
#include "refine/refine.hpp"

namespace scanmill::pipeline {

/// One file of one scan with its pose. A pose that the file holds itself (PTX) is applied before this one.
struct ViewSpec {
  std::string path;                            // relative to the archive, '/' separated
  Pose pose;                                   // view frame -> global frame; translation in mm
  bool pose_in_file_units = false;             // .conf, views: translation and eye are in the file's units
  bool mirrored = false;                       // the file's frame is left-handed: z is negated before all else
  std::string station;                         // of a plan; empty otherwise
  ViewPoint view_point;                        // in the view frame, mm; empty: what the file says itself
  std::optional<formats::DepthCamera> camera;  // depth maps need it
  bool missing = false;                        // named by the scan but not there
  std::string expected_sha256;                 // from a plan; empty when it gives none
};

enum class ScanKind { Plan, Conf, Views, SingleFile };

struct ScanSpec {
  std::string
      name;  // unique; path relative to the archive without suffix; collisions keep the suffix; unsafe bytes %XX
  ScanKind kind = ScanKind::SingleFile;
  std::string description;                   // the plan, .conf, .aln or pose file, relative; empty when there is none
  double units_mm = 0;                       // from the plan; 0 = the job's
  std::optional<scanmill::Sensor> sensor;    // from the plan: its depth band and field bound the points of every view
  std::optional<refine::Accuracy> accuracy;  // from the plan's joints
  std::vector<refine::Datum> datums;         // from the plan: bodies that move with the part
  std::vector<ViewSpec> views;               // ascending relative path as bytes; a PTX stands for all its scans
  std::vector<std::string> notes;            // missing files and the like, one sentence each
  std::string broken;  // why the scan cannot be read at all (its description is invalid); empty when fine
};

}  // namespace scanmill::pipeline
