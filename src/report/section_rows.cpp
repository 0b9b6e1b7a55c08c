// SPDX-License-Identifier: Apache-2.0
#include "base/text.hpp"
#include "report/html.hpp"
#include "report/numbers.hpp"
#include "report/sections.hpp"

namespace scanmill::report {

void add_section_rows(const ScanReport& report, std::string& out) {
  if (report.sections.empty()) return;
  add_heading(out, "sections", "Sections");
  out +=
      "<p>The line of the mesh, the measured points beside the plane (grey), and how far these are from the mesh, "
      "magnified: red outside, blue inside. The greatest deviation is ringed.</p>\n";
  {
    Table table(out, "",
                {{"section"},
                 {"line, mm", Column::Number},
                 {"slab, mm", Column::Number},
                 {"points", Column::Number},
                 {"greatest, mm", Column::Number},
                 {"rms, mm", Column::Number},
                 {"greatest at, mm", Column::Place}});
    for (const SectionRow& s : report.sections) {
      const bool known = s.points > 0;
      table.row({s.name, figure(s.length_mm), figure(s.slab_mm), grouped(s.points),
                 s.worst ? signed_figure(s.worst_signed_mm) : "-", known ? figure(s.rms_mm) : "-",
                 s.worst ? place(*s.worst) : "-"});
    }
  }
}

}  // namespace scanmill::report
