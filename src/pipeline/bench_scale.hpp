// SPDX-License-Identifier: Apache-2.0
// How the whole job scales with the number of points: made clouds of growing size, each through `scanmill run`.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "pipeline/tools.hpp"

namespace scanmill::pipeline {

struct ScaleChoice {
  std::vector<std::string> points;    // numbers such as 1e6; 1,000 to 1e12 each; 1e5, 1e6, 1e7 when empty
  std::vector<std::int64_t> threads;  // of the runs; empty: the greatest number alone
  std::vector<std::int64_t> bricks;   // edges in bins of the runs' bricks, 0 in one piece; empty: 0 alone
  double per_bin = 60;                // points that the bins hold in the mean, about; chooses the bin size
  std::uint64_t seed = 1;
  bool as_views = false;  // a file per view in place of one file
  bool keep = false;      // clouds and output trees stay in `out`
  std::string memory;     // cap of each run, as for --memory; empty: the default
  std::string out;        // folder for scale.json and scale.png; empty: none are written
  std::string generate;   // write the cloud of the one number of points to this .ply or folder, and nothing else
  std::string executable, version, processor;
  std::int64_t cores = 1;
};

/// The bin size for so many points a bin of the made clouds, in mm; a surface meets 3/2 bins per square of a bin's
/// edge.
double scale_bin_mm(double per_bin);

/// Makes each cloud, runs the job over it as child processes of `executable` with every edge of bricks at every number
/// of threads, and reports CPU and wall time, peak memory of the tree of processes, and the throughput of every stage.
/// The STL files of all runs over a cloud must hold the same bytes. Clouds are removed as soon as their runs have
/// ended. errors  BadUsage for options that cannot be and disks without room; BadInput with the words of a run that
/// fails;
///         Internal naming two runs over one cloud whose meshes differ; Cancelled
Result<ToolReport> bench_scale(const ScaleChoice& choice, const Context& context, Progress& progress);

}  // namespace scanmill::pipeline
