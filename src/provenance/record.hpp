// SPDX-License-Identifier: Apache-2.0
// The record of one scan: what went in, what was decided, what came out. One HDF5 file, the same bytes for the same
// work.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/ids.hpp"
#include "base/result.hpp"
#include "geom/vec3.hpp"
#include "mesh/mesh.hpp"
#include "mesh/section.hpp"

namespace scanmill::provenance {

struct InputEntry {
  std::string path;    // relative to the archive
  std::string sha256;  // empty for a missing file
  std::uint64_t bytes = 0;
  std::string format;             // as the reader names it
  std::string row_meaning;        // "vertex from 0", "line from 1", "point from 0" or "pixel from 0"
  std::array<double, 16> pose{};  // row-major, view -> global, mm
  double units_mm = 1;
  std::uint64_t points_read = 0, points_used = 0, not_finite = 0, sensor_invalid = 0;
  bool missing = false;
};

/// A named counter or figure of a stage; written stage by stage, by name.
struct Counter {
  std::string stage, name;
  double value = 0;
  bool integer = true;
};

struct PatchEntry {
  Vec3 seed;           // mm, global frame
  std::string origin;  // "given", "automatic", "component"
  std::uint64_t triangles = 0;
  double area_mm2 = 0, border_mm = 0;
};

/// Distances of the points nearest to one patch, mm.
struct PatchFit {
  std::uint32_t patch = 0;
  std::uint64_t points = 0;
  double max_mm = 0, rms_mm = 0, mean_mm = 0, signed_mean_mm = 0, above_mm = 0, below_mm = 0;
};

/// One of the points farthest from the mesh.
struct WorstEntry {
  Vec3 place;
  double signed_mm = 0;
  SourceKey source;
  std::uint32_t patch = 0;
  bool open_border = false;  // nearest to an open edge
};

/// Where a sentence comes from: what lies in the archive beside the scan, the scan itself (as a doubt: a warning), or
/// the files asked for.
enum class NoteKind : std::uint8_t { Archive, Finding, Warning, Output };

struct StrayEntry {  // a dropped component
  std::uint64_t triangles = 0, vertices = 0;
  Vec3 centre;
  Vec3 size;
};

/// Two views that see the same surface: their gap where the machine puts them, and where they were moved to, mm.
struct PosePair {
  std::uint32_t a = 0, b = 0;  // view ids
  std::uint64_t matches = 0;
  double before_mm = 0, after_mm = 0;
};

/// Everything a record holds; arrays by value or span as convenient. All rows in ascending bin key.
struct Record {
  std::string scan;                                                    // name
  std::string what_json;                                               // canonical JSON of the what keys
  std::string description_path, description_sha256, description_text;  // plan or .conf, when there is one
  std::vector<InputEntry> inputs;                                      // position = ViewId
  double bin_mm = 1;
  Vec3 lattice_origin;
  // reduced points: every occupied bin
  std::vector<Vec3> points;  // as measured
  std::vector<SourceKey> source;
  std::vector<std::array<std::int64_t, 3>> bins;
  std::vector<std::uint8_t> drop;  // reduce::Drop by number; names in `drop_names`
  std::vector<std::string> drop_names;
  // mesh; `vertex_row[v]` is the row of `points` behind vertex v
  const Mesh* mesh = nullptr;
  std::vector<std::uint32_t> vertex_row;
  // Fit error of each vertex's own bin, mm: signed, of largest magnitude, and rms; empty when not judged.
  std::vector<float> vertex_error, vertex_error_rms;
  std::vector<PatchEntry> patches;
  std::vector<std::vector<std::uint32_t>> patch_borders;  // polylines of vertices
  std::vector<std::uint32_t> growth_rank;                 // per triangle; may be empty
  std::vector<BorderLoop> loops;
  std::vector<StrayEntry> strays;
  std::vector<std::uint32_t> stray_rows;  // of `points`, behind the vertices of strays, ascending
  // Distances of the input points; all empty when not judged.
  std::vector<PatchFit> patch_fits;
  std::vector<WorstEntry> worst, worst_interior;  // greatest first
  std::vector<std::uint64_t> histogram;           // by signed distance: below, each step of bin_mm/32, above
  std::vector<Section> sections;                  // may be empty: nothing of them is written then
  std::vector<PosePair> pose_pairs;                // with told_poses: views were moved; else nothing of it is written
  std::vector<std::array<double, 16>> told_poses;  // of the inputs: where the machine puts them; row-major, mm
  std::vector<Counter> counters;
  std::vector<std::string> notes;
  std::vector<NoteKind> note_kinds;                                 // one per note; empty: all Finding
  std::vector<std::pair<std::string, std::string>> stage_versions;  // stage name, version
  std::vector<std::pair<std::string, std::string>> outputs;         // file name, sha256
  std::string stl_header = "scanmill binary STL UNITS=mm";  // first 80 bytes of the STL, blank-padded when shorter
};

/// Writes to the path (the caller gives a temporary folder; committing is the caller's). Deterministic bytes.
/// returns  the record's identity: SHA-256 over the canonical bytes of its datasets, which the file also holds
/// errors   IoFailed and NoSpace naming the path, what is there of the file is removed; Internal when arrays that
/// belong
///          together differ in length
Result<std::string> write_record(const Record& record, const std::string& path);

/// Identity stored in a record file (for skip decisions and checks).
Result<std::string> record_identity(const std::string& path);

}  // namespace scanmill::provenance
