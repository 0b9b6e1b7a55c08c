// SPDX-License-Identifier: Apache-2.0
// The parts of the page, each appended to `out`; nothing where nothing is known. Internal to `report`.
#pragma once
#include <string>

#include "report/scan_report.hpp"

namespace scanmill::report {

// verdict.cpp: what an operator sees first
void add_verdict(const ScanReport& report, std::string& out);
void add_tiles(const ScanReport& report, std::string& out);
void add_notes(const ScanReport& report, std::string& out);
void add_gates(const ScanReport& report, std::string& out);

// view.cpp: the 3-D view with the picture that stands for it (may be null), and behind the page its numbers and script
void add_view(const SurfaceView& view, const Picture* picture, std::string& out);
void add_view_script(const SurfaceView& view, std::string& out);

// scan_report.cpp
void add_picture(const Picture& picture, std::string& out);

// fit.cpp: the metrologist's figures
void add_fit(const ScanReport& report, std::string& out);

// surface.cpp: what became of points, and the mesh
void add_points(const ScanReport& report, std::string& out);
void add_mesh(const ScanReport& report, std::string& out);
void add_loops(const ScanReport& report, std::string& out);
void add_patches(const ScanReport& report, std::string& out);
void add_swaps(const ScanReport& report, std::string& out);

// section_rows.cpp: cuts through mesh and points, without their pictures
void add_section_rows(const ScanReport& report, std::string& out);

// origin.cpp: what went in and how to get it again
void add_parameters(const ScanReport& report, std::string& out);
void add_files(const ScanReport& report, std::string& out);
void add_footer(const ScanReport& report, std::string& out);

/// "<h2 id=...>...</h2>"
void add_heading(std::string& out, const char* id, const char* title);

}  // namespace scanmill::report
