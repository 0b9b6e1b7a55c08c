// SPDX-License-Identifier: Apache-2.0
// Mesh files: written, synced, read back and compared.
#pragma once
#include <optional>
#include <span>
#include <string>

#include "base/result.hpp"
#include "mesh/mesh.hpp"
#include "pipeline/fit_surfaces.hpp"
#include "pipeline/scan_results.hpp"
#include "pipeline/what.hpp"

namespace scanmill::pipeline {

/// What a PLY may hold beside the mesh; both empty or one per vertex, mm.
struct VertexErrors {
  std::vector<float> signed_mm, rms_mm;
};
VertexErrors vertex_errors(const verify::Report& fit);

/// Writes the mesh at `path` in the form asked for and proves that the file holds it. `bin_mm`: finest detail of the
/// mesh, where it is known. `surfaces`: of the mesh; wanted by style surfaces.
/// errors  what the sink reports; what the format cannot hold (Unsupported, BadInput); Internal when the file read back
///         is not the mesh
Result<WrittenFile> write_mesh_file(const Mesh& mesh, const Output& output, const VertexErrors& errors,
                                    const std::string& path, std::optional<double> bin_mm = {},
                                    const ScanSurfaces* surfaces = nullptr);

}  // namespace scanmill::pipeline
