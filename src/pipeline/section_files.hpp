// SPDX-License-Identifier: Apache-2.0
// Sections of a scan as files and as part of its page.
#pragma once
#include <string>
#include <vector>

#include "mesh/section.hpp"
#include "pipeline/scan_results.hpp"
#include "report/scan_report.hpp"

namespace scanmill::pipeline {

/// sections.svg and sections.dxf, with an IGES among `outputs` also sections.igs, written, synced, read back and
/// compared; nothing without sections. errors  what the sinks report; Internal when a file read back is not what was
/// written
Result<std::vector<WrittenFile>> write_section_files(const std::vector<Section>& sections,
                                                     const std::vector<Output>& outputs, const std::string& folder);

/// A row of the page per section, with its picture, which is also written as section-N.png.
/// errors  what the sinks report
Result<std::vector<report::SectionRow>> draw_sections(const std::vector<Section>& sections, const std::string& folder);

}  // namespace scanmill::pipeline
