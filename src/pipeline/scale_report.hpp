// SPDX-License-Identifier: Apache-2.0
// What `scanmill bench scale` found: as a document, as a table, as a picture.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "document/document.hpp"
#include "pipeline/bench_report.hpp"
#include "render/image.hpp"

namespace scanmill::pipeline {

/// One whole job over one cloud.
struct ScaleRun {
  std::uint64_t points = 0, bins = 0, kept = 0, triangles = 0;
  std::int64_t threads = 1, bricks = 0;  // edge of the scan's bricks in bins; 0: in one piece
  double bin_mm = 0;
  std::string stl_sha256;
  double cpu_s = 0, wall_s = 0;     // of the tree of processes, start and end included
  std::uint64_t peak_bytes = 0;     // greatest sum of memory that the tree held at a time, pages of files left out
  std::uint64_t peak_resident = 0;  // with pages of files
  std::vector<BenchStage> stages;   // one repeat each; memory from looks every 20 ms; none for scans in bricks

  double points_per_cpu_s() const;
  double kept_per_cpu_s() const;
};

struct ScaleMaking {
  std::uint64_t points = 0, bytes = 0;
  double cpu_s = 0, wall_s = 0;
};

struct ScaleReport {
  std::string version, processor, memory;  // memory: the cap as given; empty for the default
  std::int64_t cores = 1;
  std::uint64_t seed = 0;
  double per_bin = 0;
  bool as_views = false;
  std::vector<ScaleMaking> made;  // by points
  std::vector<ScaleRun> runs;     // by points, bricks, then threads
};

/// "1,000 points with 2 threads in bricks of 64 bins"
std::string name_of(const ScaleRun& run);
/// The promise that cutting and threads change no byte: `run` against the runs of `report` over the same cloud.
/// errors  Internal naming both runs
Result<void> check_same_mesh(const ScaleReport& report, const ScaleRun& run);

/// What a failed `scanmill run --json` said, of both outputs: its errors, its failed scans and gates as sentences with
/// "; " between; the last lines that are no JSON when it told of none; empty when there are none either.
std::string failure_in(const std::string& said);

/// As schemas/scale.schema.json says.
document::Node to_document(const ScaleReport& report);
/// For people.
std::string scale_table(const ScaleReport& report);
/// Points per CPU second and peak memory against the number of points, a curve per number of threads (colour) and edge
/// of bricks (dash); the memory cap, where one was given, as a line.
render::Image scale_picture(const ScaleReport& report);

}  // namespace scanmill::pipeline
