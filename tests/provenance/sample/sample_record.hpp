// SPDX-License-Identifier: Apache-2.0
// A small record of a made-up scan: a ball of 8-sided rings, seen by three views in three file formats.
#pragma once
#include <string>

#include "mesh/mesh.hpp"
#include "provenance/record.hpp"

namespace scanmill::provenance::sample {

/// Units, pose and file text of a view; the points it holds are the ball's, seen from its own frame.
struct SampleScan {
  Mesh mesh;
  Record record;  // record.mesh is not set: point it at `mesh` once the scan has its final place
};

/// Writes the views below `archive` unless it is empty, and returns what a run over them would record.
SampleScan make_scan(const std::string& archive);

/// Binary STL of the mesh as the record's reader should rebuild it.
std::string stl_bytes(const Mesh& mesh);

}  // namespace scanmill::provenance::sample
