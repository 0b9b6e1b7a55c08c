// SPDX-License-Identifier: Apache-2.0
// The tasks `swap` and `join` of a scan that is cut (cut_scan.hpp).
#pragma once
#include "base/context.hpp"
#include "base/progress.hpp"
#include "pipeline/cut_scan.hpp"
#include "pipeline/surface.hpp"

namespace scanmill::pipeline {

inline constexpr PartTask kMeshTask{PartStage::Mesh, 0}, kJoinTask{PartStage::Join, 0};

/// What `mesh` leaves. `bins`: of all rows.
Result<void> write_mesh(const Cut& cut, const MeshedSurface& surface, const std::vector<LocalBin>& bins, double bin_mm);

/// Each does nothing when its file is there.
/// errors  IoFailed naming the task that makes what is missing; those of the stage; NoSpace
Result<void> swap_batch(const Cut& cut, std::uint32_t batch, const What& what, const Context& context);
/// Where some part's neighbours saw something else, the whole mesh is swapped here.
Result<void> join_swaps(const Cut& cut, const What& what, const Context& context, Progress& progress);

}  // namespace scanmill::pipeline
