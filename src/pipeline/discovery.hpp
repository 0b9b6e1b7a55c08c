// SPDX-License-Identifier: Apache-2.0
// What scans an archive holds (design: discovery and scan names).
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "pipeline/scan_spec.hpp"
#include "pipeline/views.hpp"

namespace scanmill::pipeline {

struct Discovery {
  std::vector<ScanSpec> scans;          // by name
  std::vector<std::string> notes;       // files that look like points but are no scans, one sentence per kind
  std::vector<std::string> depth_maps;  // 16-bit grey PNGs that no entry of `views` takes, by path
  std::vector<std::string> pose_files;  // point files by name that hold nothing but 4x4 matrices, by path
};

/// The what keys that say what is a scan.
struct DiscoveryKeys {
  bool mesh_vertices_as_scan = false;
  formats::Format format = formats::Format::Auto;  // of all files that may be scans
  std::vector<ViewsSpec> views;
  /// mesh_vertices_as_scan of the scan of this name (path without suffix); empty: of the job.
  std::function<bool(const std::string& scan)> vertices_of;
};

/// Finds all scans of an archive; pure in the bytes of the archive, whatever order the system lists files in. Only
/// headers are read. A scan whose name is also the folder of another scan keeps its suffix, so that no scan's output
/// lies in another's. Scans whose names differ by letter case only are `broken`.
/// errors  IoFailed/BadInput when the archive is not there;
///         BadParameter when an entry of `views` has the name of another scan
Result<Discovery> discover(const std::string& archive, const DiscoveryKeys& keys);
inline Result<Discovery> discover(const std::string& archive, bool mesh_vertices_as_scan) {
  return discover(archive, DiscoveryKeys{mesh_vertices_as_scan, formats::Format::Auto, {}, {}});
}

}  // namespace scanmill::pipeline
