// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "base/text.hpp"
#include "report/html.hpp"
#include "report/numbers.hpp"
#include "report/sections.hpp"

namespace scanmill::report {

void add_parameters(const ScanReport& report, std::string& out) {
  if (report.parameters.empty()) return;
  add_heading(out, "parameters", "Parameters");
  const auto changed =
      std::count_if(report.parameters.begin(), report.parameters.end(), [](const Parameter& p) { return p.changed; });
  out += "<p>Everything that decides the bytes of the result; " + grouped(static_cast<std::uint64_t>(changed)) +
         " of " + grouped(report.parameters.size()) + " keys differ from their defaults.</p>\n";
  Table table(out, "", {{"key"}, {"symbol"}, {"value"}, {"unit"}, {"default"}, {"state"}});
  for (const Parameter& p : report.parameters)
    table.row({p.key, p.symbol, p.value, p.unit, p.default_value, p.changed ? "changed" : "default"},
              p.changed ? "changed" : "");
}

void add_files(const ScanReport& report, std::string& out) {
  if (report.inputs.empty() && report.outputs.empty() && report.stage_versions.empty() && report.record.empty()) return;
  add_heading(out, "files", "Files and versions");
  if (!report.inputs.empty()) {
    Table table(out, "Inputs",
                {{"file"},
                 {"format"},
                 {"bytes", Column::Number},
                 {"points read", Column::Number},
                 {"used", Column::Number},
                 {"SHA-256", Column::Digest}});
    for (const InputFile& f : report.inputs) {
      if (f.missing)
        table.row({f.path, f.format, "-", "-", "-", "missing"}, "bad");
      else
        table.row({f.path, f.format, grouped(f.bytes), grouped(f.points_read), grouped(f.points_used), f.sha256});
    }
  }
  if (!report.outputs.empty()) {
    Table table(out, "Outputs", {{"file"}, {"bytes", Column::Number}, {"SHA-256", Column::Digest}});
    for (const OutputFile& f : report.outputs) table.row({f.path, f.bytes > 0 ? grouped(f.bytes) : "-", f.sha256});
  }
  if (!report.record.empty() || !report.stage_versions.empty()) {
    Table table(out, "Versions", {{"what"}, {"version", Column::Digest}});
    if (!report.tool.empty()) table.row({"program", report.tool});
    if (!report.record.empty()) table.row({"identity of the record", report.record});
    for (const auto& [stage, version] : report.stage_versions) table.row({"stage " + stage, version});
  }
}

void add_footer(const ScanReport& report, std::string& out) {
  out += "<footer>\n";
  // One line: see kRunLine.
  if (!report.date.empty() || !report.stage_seconds.empty()) {
    out += kRunLine;
    if (!report.date.empty()) out += "Made " + escaped(report.date) + ". ";
    if (!report.stage_seconds.empty()) {
      double sum = 0;
      for (const auto& [stage, seconds] : report.stage_seconds) sum += seconds;
      out += "Time: " + escaped(figure(sum)) + " s: ";
      for (const auto& [stage, seconds] : report.stage_seconds)
        out +=
            (&stage == &report.stage_seconds.front().first ? "" : ", ") + escaped(stage + " " + figure(seconds) + " s");
      out += ".";
    }
    out += "</p>\n";
  }
  out += "<p>" + escaped(report.tool.empty() ? "scanmill" : report.tool) +
         ". Lengths in mm, places in the global frame. Signed distances are positive outside.</p>\n</footer>\n";
}

}  // namespace scanmill::report
