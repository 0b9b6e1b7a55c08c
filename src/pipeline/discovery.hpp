// SPDX-License-Identifier: Apache-2.0
// What scans an archive holds (design: discovery and scan names).
#pragma once
#include <string>
#include <vector>

#include "base/result.hpp"
#include "cloud/cloud.hpp"
#include "geom/pose.hpp"

namespace scanmill::pipeline {

/// One file of one scan with its pose.
struct ViewSpec {
  std::string path;                 // relative to the archive, '/' separated
  Pose pose;                        // view frame -> global frame; translation in mm
  bool pose_in_file_units = false;  // .conf: translation still in the file's units
  ViewPoint view_point;             // in the view frame, mm
  bool missing = false;             // named by the scan but not there
  std::string expected_sha256;      // from a plan; empty when it gives none
};

enum class ScanKind { Plan, Conf, SingleFile };

struct ScanSpec {
  std::string
      name;  // unique; path relative to the archive without suffix; collisions keep the suffix; unsafe bytes %XX
  ScanKind kind = ScanKind::SingleFile;
  std::string description;         // the plan or .conf file, relative; empty for single files
  double units_mm = 0;             // from the plan; 0 = the job's
  std::vector<ViewSpec> views;     // ascending relative path as bytes; the position is the ViewId
  std::vector<std::string> notes;  // missing files and the like, one sentence each
  std::string broken;              // why the scan cannot be read at all (its description is invalid); empty when fine
};

struct Discovery {
  std::vector<ScanSpec> scans;     // by name
  std::vector<std::string> notes;  // files that look like points but are no scans, one sentence per kind
};

/// Finds all scans of an archive; pure in the bytes of the archive, whatever order the system lists files in. Only
/// headers are read. A scan whose name is also the folder of another scan keeps its suffix, so that no scan's output
/// lies in another's.
/// errors  IoFailed/BadInput when the archive is not there; BadInput when two scan names differ by letter case only
Result<Discovery> discover(const std::string& archive, bool mesh_vertices_as_scan);

}  // namespace scanmill::pipeline
