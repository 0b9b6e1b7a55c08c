// SPDX-License-Identifier: Apache-2.0
// The mesh of a record as its report lets it be turned.
#pragma once
#include "provenance/record.hpp"
#include "report/scan_report.hpp"

namespace scanmill::pipeline {

/// Larger meshes are shown by a coarser one: at 14 bytes a triangle the view stays below 3 MB and the page below 5.
inline constexpr std::uint64_t kMostViewTriangles = 200'000;

/// Depends on mesh, patches and errors of the record only. The error of a vertex that stands for several is the
/// one of largest magnitude among theirs; of two equal ones the one above.
report::SurfaceView view_of(const provenance::Record& record);

}  // namespace scanmill::pipeline
