// SPDX-License-Identifier: Apache-2.0
// From reduced points to the finished mesh: the stage table of the middle of the job, on values only.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "base/context.hpp"
#include "base/progress.hpp"
#include "base/result.hpp"
#include "grow/grow.hpp"
#include "merge/merge.hpp"
#include "mesh/mesh.hpp"
#include "pipeline/what.hpp"
#include "reduce/reduce.hpp"
#include "stars/parts.hpp"

namespace scanmill::pipeline {

/// The finished mesh with what the stages counted.
struct MeshedSurface {
  Mesh mesh;                              // patch numbers filled in
  std::vector<std::uint32_t> vertex_row;  // row of the reduced cloud behind each vertex
  grow::Patches patches;
  std::vector<std::vector<std::uint32_t>> borders;
  std::vector<merge::Stray> strays;
  std::vector<std::uint32_t> stray_rows;  // rows behind the vertices of strays, ascending
  std::vector<BorderLoop> loops;
  stars::Report stars;
  RefusalCounts refused;
  std::uint64_t refused_overlap = 0;  // engine front only
  std::uint64_t components = 0;
  std::uint64_t sides_by_volume = 0;                // of these: no view told which side is outside
  std::uint64_t kept_used = 0, kept_in_strays = 0;  // of the kept points: vertices of the mesh, vertices of strays
};

/// Translation that keeps float32 finer than h/1000: zero near the origin, else the middle of the box rounded to a
/// multiple of 1024 bin edges.
Vec3 float32_offset(const Bounds& bounds, double edge_mm);

/// Triangles, area and border length of each patch, from the mesh.
void measure_patches(const Mesh& mesh, grow::Patches& patches);

/// Reduced points in the frame and precision in which they will be written.
struct WrittenPoints {
  std::vector<Vec3> measured, projected;
  std::vector<std::uint8_t> kept, usable;
};
WrittenPoints written_points(const reduce::ReducedCloud& cloud, Vec3 offset);
/// What the stage `stars` gets; both must outlive it.
stars::SurfacePoints surface_points(const reduce::ReducedCloud& cloud, const WrittenPoints& written);
stars::Params star_params(const What& what);

/// Stars, complete, merge, grow (or the front engine) over a reduced cloud. `ballots`: the stars' of all rows, where
/// they are there already.
/// errors  what the stages report; BadInput when no triangle can be made
Result<MeshedSurface> mesh_surface(const reduce::ReducedCloud& cloud, const Bounds& bounds, const What& what,
                                   const Context& context, Progress& progress,
                                   std::optional<std::vector<stars::Ballot>> ballots = std::nullopt);

}  // namespace scanmill::pipeline
