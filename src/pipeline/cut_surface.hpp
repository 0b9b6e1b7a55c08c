// SPDX-License-Identifier: Apache-2.0
// The mesh of a scan that is cut (cut_scan.hpp), and the distances of all points from it, piece by piece of the input.
#pragma once
#include "optimise/optimise.hpp"
#include "pipeline/cut_scan.hpp"
#include "pipeline/judge_scan.hpp"
#include "pipeline/scan_points.hpp"
#include "pipeline/surface.hpp"

namespace scanmill::pipeline {

/// What the middle of the job makes.
struct MadeSurface {
  reduce::Reduction reduction;
  MeshedSurface surface;
  optimise::Report swaps;
};

/// The task `mesh`; nothing is done when the file is there.
/// errors  IoFailed naming the task that makes what is missing; those of the stages; NoSpace
Result<void> mesh_cut(const Cut& cut, const What& what, const Context& context, Progress& progress);
/// What the tasks up to `join` made, once it is there.
Result<MadeSurface> join_surface(const Cut& cut);

/// A scan's points, and the files they come from: those keep traces of what was read.
struct TracedPoints {
  const PointSource& points;
  const ScanPoints& files;
};
/// The task `verify piece`; nothing is done when its file is there. `all`: of the scan, not the piece alone.
/// errors  IoFailed when the mesh is not there; those of measure_fit
Result<void> verify_piece(const Cut& cut, std::uint32_t piece, const TracedPoints& all, const What& what,
                          const Context& context);
/// The same as measure_fit gives over all points, from the pieces; those that are not there are made first. Leaves the
/// traces of all blocks in `all.files`.
Result<Fit> measure_fit_in_pieces(const Cut& cut, const MadeSurface& made, const TracedPoints& all, const What& what,
                                  const Context& context);

}  // namespace scanmill::pipeline
