// SPDX-License-Identifier: Apache-2.0
// An independent CAD kernel (OCCT) as reader and as rival. Only for programs built with SCANMILL_HEAVY_ORACLES.
#pragma once
#include <cstdint>
#include <string>

#include "mesh/mesh.hpp"

namespace scanmill::support {

/// What the kernel makes of an IGES file.
struct CadShape {
  bool readable = false, valid = false;
  int roots = 0, solids = 0, shells = 0, closed_shells = 0, faces = 0, edges = 0, vertices = 0;
  int invalid_faces = 0;
  double area = 0, volume = 0, line_length = 0;  // mm
};
CadShape read_with_occt(const std::string& path);

/// Edges without a partner once the faces of a file are sewn together; negative when it cannot be read.
int open_edges_with_occt(const std::string& path, double tolerance_mm);

/// The mesh as the kernel's own writer writes it (solids and shells, shared edges): CPU seconds of transfer and
/// writing, without building the shape. Negative when it fails.
double write_with_occt(const Mesh& mesh, const std::string& path);

}  // namespace scanmill::support
