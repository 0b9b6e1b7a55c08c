// SPDX-License-Identifier: Apache-2.0
// Fitted surfaces of a scan, for outputs that hold them.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "base/context.hpp"
#include "base/progress.hpp"
#include "base/result.hpp"
#include "cloud/cloud.hpp"
#include "mesh/fitted.hpp"
#include "mesh/mesh.hpp"
#include "pipeline/what.hpp"

namespace scanmill::pipeline {

struct ScanSurfaces {
  FittedSurfaces fitted;
  std::uint64_t step = 0;  // every step-th point of the cloud was used; 0: there was none, the mesh itself was
  double bin_mm = 0;
};

/// The output that asks for surfaces; nullptr when none does.
const Output* surfaces_output(const std::vector<Output>& outputs);

/// Through the points of the cloud (at most four million, evenly taken); those farther from the mesh than a bin edge,
/// or beyond its open borders, are left out.
Result<ScanSurfaces> fit_scan_surfaces(const Mesh& mesh, const PointSource& points, const Output& output, double bin_mm,
                                       const Context& context, Progress& progress);
/// Through vertices and centroids of the mesh; the bin edge is the mean edge.
Result<ScanSurfaces> fit_mesh_surfaces(const Mesh& mesh, const Output& output, const Context& context);

/// One sentence: surfaces, share of the area, errors, gap.
std::string surfaces_note(const ScanSurfaces& surfaces, const std::string& file);

}  // namespace scanmill::pipeline
