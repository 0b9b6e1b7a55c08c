// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "base/text.hpp"
#include "report/html.hpp"
#include "report/numbers.hpp"
#include "report/sections.hpp"

namespace scanmill::report {
namespace {

std::string plural(std::uint64_t count, const std::string& one) {
  return grouped(count) + " " + one + (count == 1 ? "" : "s");
}

std::string in_unit(double value, const std::string& unit) { return figure(value) + (unit.empty() ? "" : " " + unit); }

void add_tile(std::string& out, const std::string& name, const std::string& value, const std::string& below,
              bool bad = false) {
  out += std::string(bad ? "<div class=\"bad\">" : "<div>") + "<dt>" + escaped(name) + "</dt><dd>" + escaped(value) +
         "</dd><dd>" + escaped(below) + "</dd></div>\n";
}

std::string fault_words(const Mesh& mesh) {
  std::string words;
  const auto add = [&](std::uint64_t count, const char* name) {
    if (count > 0) words += (words.empty() ? "" : ", ") + grouped(count) + " " + name;
  };
  add(mesh.nonmanifold_edges, "non-manifold edges");
  add(mesh.nonmanifold_vertices, "non-manifold vertices");
  add(mesh.misoriented_edges, "mis-oriented edges");
  add(mesh.degenerate_triangles, "degenerate triangles");
  add(mesh.crossings.value_or(0), "self-intersections");
  return words;
}

}  // namespace

void add_heading(std::string& out, const char* id, const char* title) {
  out += std::string("<h2 id=\"") + id + "\">" + title + "</h2>\n";
}

void add_verdict(const ScanReport& report, std::string& out) {
  const auto failed = static_cast<std::uint64_t>(
      std::count_if(report.gates.begin(), report.gates.end(), [](const Gate& gate) { return !gate.passed; }));
  std::string mark = "none", word = "NO GATES", words = "The job sets no limit, so nothing was judged.";
  if (failed > 0) {
    mark = "fail";
    word = "\xe2\x9c\x97 FAILED";
    words.clear();
    for (const Gate& gate : report.gates)
      if (!gate.passed)
        words += (words.empty() ? "" : "; ") + gate.key + ": " + in_unit(gate.found, gate.unit) + ", limit " +
                 in_unit(gate.limit, gate.unit);
    words += ". The files are kept, marked rejected.";
  } else if (!report.gates.empty()) {
    mark = "pass";
    word = "\xe2\x9c\x93 PASSED";
    words = report.gates.size() == 1 ? "The gate is kept" : "All " + plural(report.gates.size(), "gate") + " are kept";
    for (const Gate& gate : report.gates)
      words += (&gate == &report.gates.front() ? ": " : "; ") + gate.key + " " + in_unit(gate.found, gate.unit) +
               ", limit " + in_unit(gate.limit, gate.unit);
    words += ".";
  }
  out += "<div class=\"verdict " + mark + "\"><strong>" + word + "</strong><span>" + escaped(words) + "</span></div>\n";
}

void add_tiles(const ScanReport& report, std::string& out) {
  out += "<dl class=\"tiles\">\n";
  if (report.fit) {
    const Fit& fit = *report.fit;
    const auto failed = [&](const char* word) {
      return std::any_of(report.gates.begin(), report.gates.end(),
                         [&](const Gate& g) { return !g.passed && g.key.find(word) != std::string::npos; });
    };
    add_tile(out, "greatest fit error", figure(fit.fit_error_mm) + " mm",
             "interior " + figure(fit.interior.max_mm) + ", open border " + figure(fit.open_border.max_mm),
             failed("max_error"));
    add_tile(out, "rms fit error", figure(fit.all.rms_mm) + " mm",
             fit.all.p99_mm ? "99\xc2\xa0% of the points within " + figure(*fit.all.p99_mm) : "of all points",
             failed("rms"));
    if (fit.sensor_accuracy_mm)
      add_tile(out, "with the sensor", figure(fit.fit_error_mm + *fit.sensor_accuracy_mm) + " mm",
               "fit " + figure(fit.fit_error_mm) + " + sensor " + figure(*fit.sensor_accuracy_mm));
  }
  const Mesh& mesh = report.mesh;
  add_tile(out, "triangles", grouped(mesh.triangles),
           grouped(mesh.vertices) + (mesh.vertices == 1 ? " vertex" : " vertices") +
               (report.reduction ? ", bin " + figure(report.reduction->bin_mm) + " mm" : ""));
  double longest = 0;
  for (const Loop& loop : mesh.loops) longest = std::max(longest, loop.length_mm);
  add_tile(out, "open loops", grouped(mesh.loops.size()),
           mesh.loops.empty() ? (mesh.triangles > 0 ? "the surface is closed" : "no surface")
                              : "longest " + figure(longest) + " mm");
  add_tile(out, "faults", grouped(mesh.faults()),
           mesh.faults() > 0 ? fault_words(mesh)
           : mesh.crossings  ? "manifold, oriented, no self-intersection"
                             : "manifold, oriented; self-intersections not looked for",
           mesh.faults() > 0);
  const Points& points = report.points;
  if (points.meshed)
    add_tile(out, "points on the mesh", share(*points.meshed, points.used),
             grouped(*points.meshed) + " of " + grouped(points.used) + " used, " + grouped(points.read) + " read",
             points.meshed_is_low);
  else
    add_tile(out, "points used", share(points.used, points.read), grouped(points.used) + " of " + grouped(points.read));
  out += "</dl>\n";
}

void add_notes(const ScanReport& report, std::string& out) {
  if (report.notes.empty()) return;
  out += "<ul class=\"notes\" aria-label=\"notes and warnings\">\n";
  for (const bool warning : {true, false})
    for (const Note& note : report.notes)
      if (note.warning == warning)
        out +=
            std::string(warning ? "<li class=\"w\"><b>Warning:</b> " : "<li>Note: ") + escaped(note.text) + "</li>\n";
  out += "</ul>\n";
}

void add_gates(const ScanReport& report, std::string& out) {
  if (report.gates.empty()) return;
  add_heading(out, "gates", "Gates");
  Table table(out, "", {{"gate"}, {"found", Column::Number}, {"limit", Column::Number}, {"unit"}, {"verdict"}});
  for (const Gate& gate : report.gates)
    table.row({gate.key, figure(gate.found), figure(gate.limit), gate.unit, gate.passed ? "passed" : "failed"},
              gate.passed ? "" : "bad");
}

}  // namespace scanmill::report
