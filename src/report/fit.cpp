// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "base/text.hpp"
#include "report/histogram.hpp"
#include "report/html.hpp"
#include "report/numbers.hpp"
#include "report/sections.hpp"

namespace scanmill::report {
namespace {

void add_distances(const Fit& fit, std::string& out) {
  Table table(out, "Distance of every input point from the mesh, mm",
              {{"points"},
               {"count", Column::Number},
               {"greatest", Column::Number},
               {"rms", Column::Number},
               {"mean", Column::Number},
               {"signed mean", Column::Number},
               {"outside", Column::Number},
               {"inside", Column::Number}});
  const auto row = [&](const char* name, const Distances& d) {
    if (d.count == 0) {
      table.row({name, "0", "-", "-", "-", "-", "-", "-"});
      return;
    }
    table.row({name, grouped(d.count), figure(d.max_mm), figure(d.rms_mm), figure(d.mean_mm),
               signed_figure(d.signed_mean_mm), figure(d.above_mm), figure(d.below_mm)});
  };
  row("all", fit.all);
  row("interior of the surface", fit.interior);
  row("beyond an open border", fit.open_border);
  row("at borders of patches", fit.patch_borders);
}

void add_percentiles(const Fit& fit, std::string& out) {
  if (!fit.all.p50_mm && !fit.interior.p50_mm) return;
  Table table(out, "Percentiles of the unsigned distance, mm",
              {{"points"},
               {"50 %", Column::Number},
               {"90 %", Column::Number},
               {"95 %", Column::Number},
               {"99 %", Column::Number},
               {"99.9 %", Column::Number}});
  const auto text = [](const std::optional<double>& value) { return value ? figure(*value) : std::string("-"); };
  const auto row = [&](const char* name, const Distances& d) {
    if (d.count > 0 && d.p50_mm)
      table.row({name, text(d.p50_mm), text(d.p90_mm), text(d.p95_mm), text(d.p99_mm), text(d.p999_mm)});
  };
  row("all", fit.all);
  row("interior of the surface", fit.interior);
  row("beyond an open border", fit.open_border);
  row("at borders of patches", fit.patch_borders);
}

/// "vertex 251,532 (from 0)" of "vertex from 0" and the number.
std::string row_text(const WorstPoint& p) {
  const std::size_t from = p.row_meaning.find(" from ");
  const std::string thing = p.row_meaning.empty() ? "row" : p.row_meaning.substr(0, from);
  return thing + " " + grouped(p.row) + (from == std::string::npos ? "" : " (" + p.row_meaning.substr(from + 1) + ")");
}

bool same_points(const std::vector<WorstPoint>& a, const std::vector<WorstPoint>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const WorstPoint& x, const WorstPoint& y) {
    return x.file == y.file && x.row == y.row && x.signed_mm == y.signed_mm && x.patch == y.patch;
  });
}

void add_worst(const char* caption, const std::vector<WorstPoint>& points, std::string& out) {
  if (points.empty()) return;
  Table table(out, caption,
              {{"place, mm", Column::Place},
               {"signed, mm", Column::Number},
               {"where"},
               {"patch", Column::Number},
               {"file and row"}});
  for (const WorstPoint& p : points)
    table.row({place(p.place), signed_figure(p.signed_mm), p.open_border ? "open border" : "interior", grouped(p.patch),
               p.file + ", " + row_text(p)});
}

}  // namespace

void add_fit(const ScanReport& report, std::string& out) {
  if (!report.fit) return;
  const Fit& fit = *report.fit;
  add_heading(out, "fit", "Fit error");
  out += "<p>The fit error is the greatest distance of any input point from the mesh.";
  out += fit.sensor_accuracy_mm
             ? " The sensor's accuracy is its maker's or its calibration's figure, stated apart; the "
               "sum bounds the error of the model.</p>\n"
             : " The job does not tell the sensor's accuracy, so no sum is stated.</p>\n";
  {
    Table table(out, "", {{"error"}, {"mm", Column::Number}});
    table.row({"fit error (greatest distance)", figure(fit.fit_error_mm)});
    if (fit.sensor_accuracy_mm) {
      table.row({"accuracy of the sensor", figure(*fit.sensor_accuracy_mm)});
      table.row({"sum", figure(fit.fit_error_mm + *fit.sensor_accuracy_mm)}, "changed");
    }
    if (fit.coverage) table.row({"share of triangles with an input point near", figure(100 * *fit.coverage) + " %"});
  }
  std::optional<double> limit;
  for (const Gate& gate : report.gates)
    if (gate.key.find("max_error") != std::string::npos) limit = gate.limit;
  out += histogram_figure(fit.histogram, limit);
  add_distances(fit, out);
  add_percentiles(fit, out);
  add_worst("Worst points", fit.worst, out);
  if (!same_points(fit.worst, fit.worst_interior)) add_worst("Worst points of the interior", fit.worst_interior, out);
}

}  // namespace scanmill::report
