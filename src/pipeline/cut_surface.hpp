// SPDX-License-Identifier: Apache-2.0
// The tasks of a scan behind its reduction (cut_scan.hpp): the mesh, kept so that it is made once, and the distances of
// all points from it, piece by piece of the input.
#pragma once
#include <optional>

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

/// errors  NoSpace, IoFailed naming the file
Result<void> keep_surface(const Cut& cut, const MadeSurface& made);
/// Nothing when the task `mesh` is still to be done.
/// errors  IoFailed naming the file
Result<std::optional<MadeSurface>> kept_surface(const Cut& cut);

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
