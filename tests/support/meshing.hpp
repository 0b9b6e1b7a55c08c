// SPDX-License-Identifier: Apache-2.0
// From points in memory to a meshed surface through the same stages as a job.
#pragma once
#include <vector>

#include "cloud/cloud.hpp"
#include "pipeline/surface.hpp"
#include "support/mesh_checker.hpp"

namespace scanmill::support {

struct Meshed {
  reduce::Reduction reduction;
  pipeline::MeshedSurface surface;
};

/// The what of a job with only a bin edge.
pipeline::What what_of(double bin_mm, pipeline::Profile profile = pipeline::Profile::Scan);

/// A loop of `threads` workers with a flag that is never set.
struct Workers {
  explicit Workers(int threads = 1) : loop(threads) {}
  ChunkLoop loop;
  CancelFlag cancel;
  Context context() const { return {loop, cancel}; }
};

Result<Meshed> mesh_cloud(const PointSource& points, const pipeline::What& what, int threads = 1);
Result<Meshed> mesh_points(std::vector<Vec3> points, const pipeline::What& what, int threads = 1);

/// The findings of a mesh under the limits of its job.
MeshFindings judge(const Meshed& meshed, const pipeline::What& what);

}  // namespace scanmill::support
