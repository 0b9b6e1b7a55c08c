// SPDX-License-Identifier: Apache-2.0
// The job's key `views`: scans given by hand, as a pattern of files with poses and the numbers of the camera.
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "document/document.hpp"
#include "document/read_fields.hpp"
#include "formats/poses.hpp"
#include "formats/view_reader.hpp"
#include "pipeline/scan_spec.hpp"

namespace scanmill::pipeline {

/// One entry of `views`. Paths are relative to the archive.
struct ViewsSpec {
  std::string name;                            // of the scan
  std::string files;                           // pattern; * and ? as in `scans`
  std::int64_t every = 1;                      // of the matching files the first, and every so many
  std::string poses;                           // a file that read_poses reads; empty: none
  std::optional<std::array<double, 16>> pose;  // of all files; the translation is in their units
  std::optional<Vec3> eye;                     // of all files, in the frame and units of each
  std::optional<formats::DepthCamera> camera;
};

/// Reads the list; problems go to `problems`, entry by entry.
std::vector<ViewsSpec> read_views(const document::Node& list, document::Problems& problems);
/// The keys intrinsics and depth_scale of a map; empty without intrinsics. `key` is the map's own, for problems.
std::optional<formats::DepthCamera> read_camera(const document::Node& map, const std::string& key,
                                                document::Problems& problems);
/// The list as read_views takes it, defaults filled in.
document::Node to_document(const std::vector<ViewsSpec>& views);
/// Draft-07 schema of the list.
document::Node views_schema();

/// "a/./b//c" as a listing of files would name it: "a/b/c".
std::string plain_path(const std::string& path);
/// "frame2" before "frame10": runs of digits compare as numbers, all else as bytes; ties by bytes.
bool natural_before(const std::string& a, const std::string& b);

/// The scan of one entry. `files` are all files of the archive, `poses` what its pose file holds (or the reason why it
/// cannot be read). Files match in natural order; where poses carry names they go by name, else pose k goes to file k,
/// counted before `every` thins them. `matched` receives every file that matches, thinned ones included.
/// returns  a scan whose `broken` says what does not fit: no file, counts that differ (both are named), a file without
///          a pose
ScanSpec scan_of_views(const ViewsSpec& spec, const std::vector<std::string>& files,
                       const Result<std::vector<formats::NamedPose>>& poses, std::vector<std::string>& matched);

}  // namespace scanmill::pipeline
