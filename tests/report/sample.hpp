// SPDX-License-Identifier: Apache-2.0
// A report with every field filled, as the pipeline fills it after a scan; numbers are made up but fit together.
#pragma once
#include "report/scan_report.hpp"

namespace scanmill::report {

/// Fails no gate.
ScanReport sample_report();
/// A rough sheet of wide x high squares, two triangles each, one side of it open.
SurfaceView sample_view(std::uint32_t wide, std::uint32_t high);
/// What a scan without gates, sensor, pictures and fit leaves: the least there is.
ScanReport bare_report();

}  // namespace scanmill::report
