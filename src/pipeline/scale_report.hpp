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
  std::int64_t threads = 1;
  double bin_mm = 0;
  double cpu_s = 0, wall_s = 0;     // of the tree of processes, start and end included
  std::uint64_t peak_bytes = 0;     // greatest sum of memory that the tree held at a time, pages of files left out
  std::uint64_t peak_resident = 0;  // with pages of files
  std::vector<BenchStage> stages;   // one repeat each; CPU and memory from looks every 20 ms

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
  std::vector<ScaleRun> runs;     // by points, then threads
};

/// As schemas/scale.schema.json says.
document::Node to_document(const ScaleReport& report);
/// For people.
std::string scale_table(const ScaleReport& report);
/// Points per CPU second and peak memory against the number of points, a curve per number of threads.
render::Image scale_picture(const ScaleReport& report);

}  // namespace scanmill::pipeline
