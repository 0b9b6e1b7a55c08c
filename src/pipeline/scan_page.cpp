// SPDX-License-Identifier: Apache-2.0
#include "pipeline/scan_page.hpp"

#include <algorithm>

#include "base/text.hpp"
#include "pipeline/density.hpp"
#include "pipeline/run_scan.hpp"

namespace scanmill::pipeline {
namespace {

using document::Node;

report::Distances distances_of(const verify::DistanceFigures& from) {
  report::Distances to;
  to.count = from.count;
  to.max_mm = from.max_mm;
  to.rms_mm = from.rms_mm;
  to.mean_mm = from.mean_mm;
  to.signed_mean_mm = from.signed_mean_mm;
  to.above_mm = from.above_mm;
  to.below_mm = from.below_mm;
  if (from.percentiles) {
    to.p50_mm = from.percentiles->p50;
    to.p90_mm = from.percentiles->p90;
    to.p95_mm = from.percentiles->p95;
    to.p99_mm = from.percentiles->p99;
    to.p999_mm = from.percentiles->p999;
  }
  return to;
}

std::vector<report::WorstPoint> worst_of(const std::vector<verify::WorstPoint>& from, const ScanPoints& points) {
  std::vector<report::WorstPoint> list;
  for (const verify::WorstPoint& worst : from) {
    report::WorstPoint row;
    row.place = worst.place;
    row.signed_mm = worst.signed_mm;
    row.row = worst.source.row;
    row.patch = worst.patch;
    row.open_border = worst.open_border;
    for (const OpenView& view : points.views())
      if (view.id == worst.source.view) {
        row.file = view.path;
        row.row_meaning = formats::name_of(view.header.row_meaning);
      }
    list.push_back(std::move(row));
  }
  return list;
}

report::Fit fit_of(const ScanResults& results) {
  const verify::Report& from = results.fit;
  report::Fit fit;
  fit.all = distances_of(from.all);
  fit.interior = distances_of(from.interior);
  fit.open_border = distances_of(from.open_border);
  fit.patch_borders = distances_of(from.patch_borders);
  fit.histogram.low_mm = -verify::SignedHistogram::kBinsEachSide * from.bin_mm;
  fit.histogram.step_mm = from.histogram.step_mm;
  fit.histogram.counts.assign(from.histogram.counts.begin(), from.histogram.counts.end());
  fit.histogram.below = from.histogram.below;
  fit.histogram.above = from.histogram.above;
  fit.worst = worst_of(from.worst, results.points);
  fit.worst_interior = worst_of(from.worst_interior, results.points);
  fit.fit_error_mm = from.fit_error_mm;
  fit.sensor_accuracy_mm = from.sensor_accuracy_mm;
  if (from.coverage.triangles > 0)
    fit.coverage = static_cast<double>(from.coverage.triangles_near) / static_cast<double>(from.coverage.triangles);
  return fit;
}

report::Mesh mesh_of(const ScanResults& results) {
  const verify::Quality& q = results.quality;
  report::Mesh mesh;
  mesh.vertices = q.topology.vertices_used;
  mesh.triangles = q.topology.triangles;
  mesh.patches = results.surface.patches.patches.size();
  mesh.components = q.topology.components;
  mesh.boundary_edges = q.topology.boundary_edges;
  mesh.euler = q.topology.euler;
  mesh.nonmanifold_edges = q.topology.nonmanifold_edges;
  mesh.nonmanifold_vertices = q.topology.nonmanifold_vertices;
  mesh.misoriented_edges = q.topology.misoriented_edges;
  mesh.degenerate_triangles = q.repeated_corners + q.zero_area_triangles;
  mesh.crossings = q.crossing_pairs;
  for (const verify::Crossing& c : q.crossings) mesh.crossing_places.push_back({c.first, c.second, c.place, {}});
  for (const BorderLoop& loop : q.loops) mesh.loops.push_back({loop.length_mm, loop.vertices.size(), loop.centre});
  for (const merge::Stray& stray : results.surface.strays)
    mesh.dropped.push_back(
        {stray.triangles, stray.vertices, (stray.bounds.low + stray.bounds.high) * 0.5, stray.bounds.size()});
  mesh.smallest_angle_deg = q.angles.least;
  mesh.smallest_angle_p5_deg = q.angles.p5;
  mesh.g2_deg = results.what.grow.min_angle_deg;
  mesh.longest_edge_mm = q.edges.greatest;
  mesh.g1_mm = results.what.grow.range_bins * results.reduction.report.bin_mm;
  mesh.area_mm2 = q.area_mm2;
  if (q.closed_manifold) mesh.volume_mm3 = q.volume_mm3;
  return mesh;
}

void add_points(const ScanResults& results, report::ScanReport& page) {
  const reduce::Report& r = results.reduction.report;
  page.points.read = r.points_read;
  page.points.used = r.points_used;
  page.points.meshed = results.fit.points_near;
  page.points.meshed_is_low =
      static_cast<double>(results.fit.points_near) < kLeastMeshedShare * static_cast<double>(r.points_used);
  page.points.dropped = {{"not finite", r.not_finite}, {"no measurement in the cell", r.sensor_invalid}};
  if (results.cleaned.cleaned) {
    const clean::RuleCounts counts = results.cleaned.cleaned->counts();
    for (std::size_t rule = 1; rule < clean::kRules; ++rule)
      if (counts.points[rule] > 0)
        page.points.dropped.push_back({clean::name_of(static_cast<clean::Rule>(rule)), counts.points[rule]});
  }
  page.reduction = report::Reduction{r.bin_mm,
                                     r.bins,
                                     r.kept,
                                     {{"fewer points than min_points_per_bin", r.dropped_too_few},
                                      {"isolated: no local plane", r.dropped_isolated},
                                      {"c1: far from the bin's centre", r.dropped_centre_distance},
                                      {"c2: too near to another", r.dropped_neighbour_distance}}};
}

void add_swaps(const optimise::Report& swaps, report::ScanReport& page) {
  auto add = [&](const char* name, const optimise::PassReport& pass) {
    if (pass.done)
      page.swaps.push_back({name, pass.rounds, pass.swaps, pass.angle_p5_before_deg, pass.angle_p5_after_deg});
  };
  add("smooth", swaps.smooth);
  add("feature", swaps.feature);
  if (!swaps.feature.done) return;
  auto creases = [](const optimise::Creases& c) {
    return report::Creases{c.dihedral_sum_deg, c.normal_variation_rms, c.sharp_length_mm, c.sharp_edges};
  };
  page.creases_before = creases(swaps.before_feature);
  page.creases_after = creases(swaps.after_feature);
}

std::string value_text(const Node& node) {
  if (node.is_null()) return "off";
  return node.is_string() ? node.as_string() : document::to_json(node);
}

std::string unit_of(std::string_view key) {
  for (const auto& [suffix, unit] :
       {std::pair("_mm", "mm"), std::pair("_deg", "degrees"), std::pair("_bins", "bin edges")})
    if (key.ends_with(suffix)) return unit;
  return key == "max_centre_distance" || key == "min_neighbour_distance" ? "bin edges" : "";
}

std::string symbol_of(const std::string& section, const std::string& key) {
  for (const WhatField& field : what_fields())
    if (field.section == section && field.field->name == key) return std::string(field.field->symbol);
  return {};
}

/// Leaves of the tree of what keys, two levels deep, beside their defaults.
void add_parameters(const Node& tree, const Node& defaults, const std::string& section, report::ScanReport& page) {
  for (const Node::Entry& entry : tree.entries()) {
    const Node* preset = defaults.is_map() ? defaults.find(entry.key) : nullptr;
    if (section.empty() && entry.value.is_map()) {
      add_parameters(entry.value, preset ? *preset : Node::map(), entry.key, page);
      continue;
    }
    report::Parameter row;
    row.key = section.empty() ? entry.key : section + "." + entry.key;
    row.symbol = symbol_of(section, entry.key);
    row.value = value_text(entry.value);
    row.unit = unit_of(entry.key);
    row.default_value = preset ? value_text(*preset) : "off";
    row.changed = row.value != row.default_value;
    page.parameters.push_back(std::move(row));
  }
}

void add_files(const ScanResults& results, report::ScanReport& page) {
  const std::vector<ViewSpec>& specs = results.points.specs();
  const std::vector<ViewCounts> counts = results.points.counts();
  std::vector<clean::RuleCounts> removed;
  if (results.cleaned.cleaned) removed = results.cleaned.cleaned->counts_by_view();
  for (const ViewSpec& spec : specs) {
    report::InputFile& file = page.inputs.emplace_back();
    file.path = spec.path;
    file.missing = true;
  }
  for (std::size_t k = 0; k < results.points.views().size(); ++k) {
    const OpenView& view = results.points.views()[k];
    const std::size_t id = index_of(view.id);
    if (id >= page.inputs.size()) page.inputs.resize(id + 1);
    report::InputFile& file = page.inputs[id];
    file.path = view.path;
    file.missing = false;
    file.format = view.header.format;
    file.bytes = view.stamp.size;
    file.points_read = counts[k].points_read;
    file.points_used = counts[k].kept() - (id < removed.size() ? removed[id].removed() : 0);
    file.sha256 = results.digests[k];
  }
  for (const WrittenFile& output : results.outputs) page.outputs.push_back({output.name, output.bytes, output.sha256});
}

}  // namespace

report::ScanReport page_of(const ScanResults& results, std::vector<report::Picture> pictures,
                           std::vector<report::SectionRow> sections, const PageFrame& frame) {
  report::ScanReport page;
  page.scan = results.scan.name;
  page.job = frame.job;
  page.tool = frame.tool;
  page.record = frame.record;
  for (const verify::Gate& gate : results.fit.gates)
    page.gates.push_back({"verify." + gate.name, gate.limit, gate.found, "mm", gate.passed});
  for (const std::string& note : results.notes) {
    const bool is_warning = std::find(results.warnings.begin(), results.warnings.end(), note) != results.warnings.end();
    page.notes.push_back({is_warning, note});
  }
  page.pictures = std::move(pictures);
  page.sections = std::move(sections);
  add_points(results, page);
  page.mesh = mesh_of(results);
  page.fit = fit_of(results);
  for (std::size_t p = 0; p < results.surface.patches.patches.size(); ++p) {
    const grow::Patch& patch = results.surface.patches.patches[p];
    report::PatchRow row;
    row.number = p;
    row.origin = grow::name_of(patch.origin);
    row.seed = patch.seed;
    row.triangles = patch.triangles;
    row.area_mm2 = patch.area_mm2;
    for (const verify::PatchFigures& figures : results.fit.patches)
      if (figures.patch == p) row.distances = distances_of(figures.distances);
    page.patches.push_back(std::move(row));
  }
  add_swaps(results.swaps, page);
  What defaults;
  defaults.profile = results.what.profile;
  add_parameters(to_document(what_for(results.what, results.scan.name)), to_document(defaults), "", page);
  add_files(results, page);
  page.stage_versions = stage_versions();
  page.date = frame.date;
  page.stage_seconds = frame.stage_seconds;
  return page;
}

}  // namespace scanmill::pipeline
