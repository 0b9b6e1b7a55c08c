// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <numeric>

#include "base/text.hpp"
#include "report/html.hpp"
#include "report/numbers.hpp"
#include "report/sections.hpp"

namespace scanmill::report {
namespace {

std::string or_dash(const std::optional<double>& value) { return value ? figure(*value) : "-"; }

void add_rest(std::string& out, std::size_t shown, std::size_t all, const char* things) {
  if (all > shown)
    out += "<p class=\"quiet\">" + grouped(all - shown) + " more " + things +
           " are not listed here; the record has all.</p>\n";
}

void add_soundness(const Mesh& m, std::string& out) {
  Table table(out, "Zero on a sound mesh", {{"fault"}, {"count", Column::Number}});
  const auto row = [&](const char* name, std::uint64_t count) {
    table.row({name, grouped(count)}, count > 0 ? "bad" : "");
  };
  row("non-manifold edges", m.nonmanifold_edges);
  row("non-manifold vertices", m.nonmanifold_vertices);
  row("mis-oriented edges", m.misoriented_edges);
  row("degenerate triangles", m.degenerate_triangles);
  if (m.crossings)
    row("self-intersections", *m.crossings);
  else
    table.row({"self-intersections", "not looked for"});
}

void add_counts(const Mesh& m, std::string& out) {
  Table table(out, "Mesh", {{"figure"}, {"value", Column::Number}, {"unit"}});
  table.row({"triangles", grouped(m.triangles), ""});
  table.row({"vertices", grouped(m.vertices), ""});
  table.row({"patches", grouped(m.patches), ""});
  table.row({"components", grouped(m.components), ""});
  table.row({"open loops", grouped(m.loops.size()), ""});
  table.row({"open edges", grouped(m.boundary_edges), ""});
  table.row({"Euler number", std::to_string(m.euler), ""});
  if (m.area_mm2) table.row({"area", figure(*m.area_mm2), "mm\xc2\xb2"});
  if (m.volume_mm3) table.row({"enclosed volume", figure(*m.volume_mm3), "mm\xc2\xb3"});
}

void add_shape(const Mesh& m, std::string& out) {
  Table table(out, "Triangles", {{"figure"}, {"value", Column::Number}, {"limit", Column::Number}, {"unit"}});
  const bool small = m.smallest_angle_deg && m.g2_deg && *m.smallest_angle_deg < *m.g2_deg;
  const bool long_edge = m.longest_edge_mm && m.g1_mm && *m.longest_edge_mm > *m.g1_mm;
  if (m.smallest_angle_p5_deg)
    table.row({"smallest angle, 5th percentile", figure(*m.smallest_angle_p5_deg), "-", "degrees"});
  if (m.smallest_angle_deg)
    table.row({"smallest angle of all (g2)", figure(*m.smallest_angle_deg), or_dash(m.g2_deg), "degrees"},
              small ? "bad" : "");
  if (m.mean_edge_mm) table.row({"mean edge", figure(*m.mean_edge_mm), "-", "mm"});
  if (m.longest_edge_mm)
    table.row({"longest edge (g1)", figure(*m.longest_edge_mm), or_dash(m.g1_mm), "mm"}, long_edge ? "bad" : "");
}

void add_crossings(const Mesh& m, std::string& out) {
  if (m.crossing_places.empty()) return;
  const std::size_t shown = std::min(m.crossing_places.size(), kLoopsShown);
  {
    Table table(
        out, "Self-intersections",
        {{"place, mm", Column::Place}, {"triangle", Column::Number}, {"and triangle", Column::Number}, {"cause"}});
    for (std::size_t i = 0; i < shown; ++i) {
      const Crossing& c = m.crossing_places[i];
      table.row({place(c.place), grouped(c.first), grouped(c.second), c.cause.empty() ? "not known" : c.cause}, "bad");
    }
  }
  add_rest(out, shown, std::max<std::size_t>(m.crossing_places.size(), m.crossings.value_or(0)), "pairs");
}

}  // namespace

void add_points(const ScanReport& report, std::string& out) {
  add_heading(out, "points", "Points");
  out += "<div class=\"columns\">\n";
  {
    Table table(out, "Points of the files", {{"points"}, {"count", Column::Number}, {"share", Column::Number}});
    const Points& p = report.points;
    table.row({"read", grouped(p.read), p.read > 0 ? "100 %" : "-"});
    for (const Dropped& d : p.dropped) table.row({"dropped: " + d.reason, grouped(d.count), share(d.count, p.read)});
    table.row({"used", grouped(p.used), share(p.used, p.read)}, "changed");
    if (p.meshed)
      table.row({"within one bin edge of the mesh", grouped(*p.meshed), share(*p.meshed, p.read)},
                p.meshed_is_low ? "bad" : "");
  }
  if (report.reduction) {
    const Reduction& r = *report.reduction;
    Table table(out, "Bins of " + figure(r.bin_mm) + " mm",
                {{"bins"}, {"count", Column::Number}, {"share", Column::Number}});
    table.row({"occupied", grouped(r.bins), r.bins > 0 ? "100 %" : "-"});
    for (const Dropped& d : r.thinned) table.row({"left out: " + d.reason, grouped(d.count), share(d.count, r.bins)});
    table.row({"kept for the mesh", grouped(r.kept), share(r.kept, r.bins)}, "changed");
  }
  out += "</div>\n";
}

void add_mesh(const ScanReport& report, std::string& out) {
  const Mesh& m = report.mesh;
  add_heading(out, "mesh", "Mesh");
  out += "<div class=\"columns\">\n";
  add_counts(m, out);
  add_soundness(m, out);
  if (m.smallest_angle_p5_deg || m.smallest_angle_deg || m.mean_edge_mm || m.longest_edge_mm) add_shape(m, out);
  out += "</div>\n";
  add_crossings(m, out);
  if (m.dropped.empty()) return;
  const std::size_t shown = std::min(m.dropped.size(), kComponentsShown);
  {
    Table table(out, "Pieces left out of the mesh (smaller than min_component_share)",
                {{"centre, mm", Column::Place},
                 {"size, mm", Column::Place},
                 {"triangles", Column::Number},
                 {"vertices", Column::Number}});
    for (std::size_t i = 0; i < shown; ++i) {
      const Component& c = m.dropped[i];
      table.row({place(c.centre), place(c.size), grouped(c.triangles), grouped(c.vertices)});
    }
  }
  add_rest(out, shown, m.dropped.size(), "pieces");
}

void add_loops(const ScanReport& report, std::string& out) {
  const auto& loops = report.mesh.loops;
  add_heading(out, "loops", "Open loops");
  if (loops.empty()) {
    out += "<p>None: the surface is closed.</p>\n";
    return;
  }
  std::vector<std::size_t> order(loops.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return loops[a].length_mm > loops[b].length_mm; });
  double sum = 0;
  for (const std::size_t i : order) sum += loops[i].length_mm;
  out += "<p>" + grouped(loops.size()) + (loops.size() == 1 ? " loop" : " loops") + ", " + escaped(figure(sum)) +
         " mm together. No surface was invented here: nothing was measured within g1.</p>\n";
  const std::size_t shown = std::min(loops.size(), kLoopsShown);
  {
    Table table(out, "Longest first",
                {{"number"}, {"length, mm", Column::Number}, {"edges", Column::Number}, {"centre, mm", Column::Place}});
    for (std::size_t k = 0; k < shown; ++k) {
      const Loop& loop = loops[order[k]];
      table.row({grouped(k + 1), figure(loop.length_mm), grouped(loop.edges), place(loop.centre)});
    }
  }
  add_rest(out, shown, loops.size(), "loops");
}

void add_patches(const ScanReport& report, std::string& out) {
  if (report.patches.empty()) return;
  add_heading(out, "patches", "Patches");
  const std::size_t shown = std::min(report.patches.size(), kPatchesShown);
  {
    Table table(out, "",
                {{"patch"},
                 {"seed"},
                 {"seed at, mm", Column::Place},
                 {"triangles", Column::Number},
                 {"area, mm\xc2\xb2", Column::Number},
                 {"greatest, mm", Column::Number},
                 {"rms, mm", Column::Number},
                 {"signed mean, mm", Column::Number}});
    for (std::size_t i = 0; i < shown; ++i) {
      const PatchRow& p = report.patches[i];
      const bool known = p.distances && p.distances->count > 0;
      table.row({grouped(p.number) + (p.name.empty() ? "" : " " + p.name), p.origin, place(p.seed),
                 grouped(p.triangles), figure(p.area_mm2), known ? figure(p.distances->max_mm) : "-",
                 known ? figure(p.distances->rms_mm) : "-", known ? signed_figure(p.distances->signed_mean_mm) : "-"});
    }
  }
  add_rest(out, shown, report.patches.size(), "patches");
}

void add_swaps(const ScanReport& report, std::string& out) {
  if (report.swaps.empty() && !(report.creases_before && report.creases_after)) return;
  add_heading(out, "swaps", "Edge swaps and creases");
  out += "<div class=\"columns\">\n";
  if (!report.swaps.empty()) {
    Table table(out, "Passes",
                {{"pass"},
                 {"rounds", Column::Number},
                 {"swaps", Column::Number},
                 {"angle p5 before, deg", Column::Number},
                 {"after, deg", Column::Number}});
    for (const Swaps& s : report.swaps)
      table.row(
          {s.pass, grouped(s.rounds), grouped(s.swaps), or_dash(s.angle_p5_before_deg), or_dash(s.angle_p5_after_deg)});
  }
  if (report.creases_before && report.creases_after) {
    const Creases &a = *report.creases_before, &b = *report.creases_after;
    Table table(out, "Creases, before and after the feature pass",
                {{"figure"}, {"before", Column::Number}, {"after", Column::Number}, {"unit"}});
    table.row({"sum of angles between neighbours", figure(a.dihedral_sum_deg), figure(b.dihedral_sum_deg), "degrees"});
    table.row({"variation of normals, rms", figure(a.normal_variation_rms), figure(b.normal_variation_rms), ""});
    table.row({"edges sharper than 30 degrees", grouped(a.sharp_edges), grouped(b.sharp_edges), ""});
    table.row({"their length", figure(a.sharp_length_mm), figure(b.sharp_length_mm), "mm"});
  }
  out += "</div>\n";
}

}  // namespace scanmill::report
