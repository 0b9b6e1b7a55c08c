// SPDX-License-Identifier: Apache-2.0
#include "pipeline/scan_page.hpp"

#include <algorithm>

#include "base/text.hpp"
#include "pipeline/density.hpp"
#include "pipeline/page_view.hpp"
#include "pipeline/run_scan.hpp"
#include "pipeline/scan_record.hpp"

namespace scanmill::pipeline {
namespace {

using document::Node;
using provenance::Record;

/// Figures of a class of points by the beginning of their names in the record.
report::Distances distances_of(const Record& record, const std::string& which) {
  const auto of = [&](const char* name) { return figure(record, "verify", which + name); };
  report::Distances to;
  to.count = count(record, "verify", which + "points");
  to.max_mm = of("max_mm");
  to.rms_mm = of("rms_mm");
  to.mean_mm = of("mean_mm");
  to.signed_mean_mm = of("signed_mean_mm");
  to.above_mm = of("above_mm");
  to.below_mm = of("below_mm");
  if (has_figure(record, "verify", which + "p50_mm")) {
    to.p50_mm = of("p50_mm");
    to.p90_mm = of("p90_mm");
    to.p95_mm = of("p95_mm");
    to.p99_mm = of("p99_mm");
    to.p999_mm = of("p99_9_mm");
  }
  return to;
}

report::Distances distances_of(const provenance::PatchFit& from) {
  report::Distances to;
  to.count = from.points;
  to.max_mm = from.max_mm;
  to.rms_mm = from.rms_mm;
  to.mean_mm = from.mean_mm;
  to.signed_mean_mm = from.signed_mean_mm;
  to.above_mm = from.above_mm;
  to.below_mm = from.below_mm;
  return to;
}

std::vector<report::WorstPoint> worst_of(const std::vector<provenance::WorstEntry>& from, const Record& record) {
  std::vector<report::WorstPoint> list;
  for (const provenance::WorstEntry& worst : from) {
    report::WorstPoint row;
    row.place = worst.place;
    row.signed_mm = worst.signed_mm;
    row.row = worst.source.row;
    row.patch = worst.patch;
    row.open_border = worst.open_border;
    if (const std::size_t view = index_of(worst.source.view); view < record.inputs.size()) {
      row.file = record.inputs[view].path;
      row.row_meaning = record.inputs[view].row_meaning;
    }
    list.push_back(std::move(row));
  }
  return list;
}

report::Fit fit_of(const Record& record) {
  report::Fit fit;
  fit.all = distances_of(record, "");
  fit.interior = distances_of(record, "interior_");
  fit.open_border = distances_of(record, "open_border_");
  fit.patch_borders = distances_of(record, "patch_border_");
  fit.histogram.low_mm = -verify::SignedHistogram::kBinsEachSide * record.bin_mm;
  fit.histogram.step_mm = record.bin_mm / verify::SignedHistogram::kStepsPerBin;
  if (record.histogram.size() >= 2) {
    fit.histogram.counts.assign(record.histogram.begin() + 1, record.histogram.end() - 1);
    fit.histogram.below = record.histogram.front();
    fit.histogram.above = record.histogram.back();
  }
  fit.worst = worst_of(record.worst, record);
  fit.worst_interior = worst_of(record.worst_interior, record);
  fit.fit_error_mm = figure(record, "verify", "fit_error_mm");
  fit.sensor_accuracy_mm = figure(record, "verify", "sensor_accuracy_mm");
  if (const std::size_t triangles = record.mesh->triangles.size(); triangles > 0)
    fit.coverage = figure(record, "verify", "triangles_with_points") / static_cast<double>(triangles);
  return fit;
}

report::Mesh mesh_of(const FinishedScan& scan, const What& what) {
  const verify::Quality& q = scan.quality;
  const Record& record = scan.record;
  report::Mesh mesh;
  mesh.vertices = q.topology.vertices_used;
  mesh.triangles = q.topology.triangles;
  mesh.patches = record.patches.size();
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
  for (const provenance::StrayEntry& stray : record.strays)
    mesh.dropped.push_back({stray.triangles, stray.vertices, stray.centre, stray.size});
  mesh.smallest_angle_deg = q.angles.least;
  mesh.smallest_angle_p5_deg = q.angles.p5;
  mesh.g2_deg = what.grow.min_angle_deg;
  mesh.longest_edge_mm = q.edges.greatest;
  mesh.g1_mm = what.grow.range_bins * record.bin_mm;
  mesh.area_mm2 = q.area_mm2;
  if (q.closed_manifold) mesh.volume_mm3 = q.volume_mm3;
  return mesh;
}

void add_points(const Record& record, report::ScanReport& page) {
  const auto reduced = [&](const char* name) { return count(record, "reduce", name); };
  page.points.read = count(record, "read", "points_read");
  page.points.used = reduced("points_used");
  page.points.meshed = count(record, "verify", "points_near");
  page.points.meshed_is_low =
      static_cast<double>(*page.points.meshed) < kLeastMeshedShare * static_cast<double>(page.points.used);
  page.points.dropped = {{"not finite", count(record, "read", "not_finite")},
                         {"no measurement in the cell", count(record, "read", "sensor_invalid")}};
  for (std::size_t rule = 1; rule < clean::kRules; ++rule)
    if (const std::uint64_t removed = count(record, "clean", kCleanCounters[rule]); removed > 0)
      page.points.dropped.push_back({clean::name_of(static_cast<clean::Rule>(rule)), removed});
  page.reduction = report::Reduction{record.bin_mm,
                                     reduced("bins"),
                                     reduced("kept"),
                                     {{"fewer points than min_points_per_bin", reduced("dropped_too_few")},
                                      {"isolated: no local plane", reduced("dropped_isolated")},
                                      {"c1: far from the bin's centre", reduced("dropped_centre_distance")},
                                      {"c2: too near to another", reduced("dropped_neighbour_distance")}}};
}

void add_patches(const Record& record, report::ScanReport& page) {
  for (std::size_t p = 0; p < record.patches.size(); ++p) {
    const provenance::PatchEntry& patch = record.patches[p];
    report::PatchRow row;
    row.number = p;
    row.origin = patch.origin;
    row.seed = patch.seed;
    row.triangles = patch.triangles;
    row.area_mm2 = patch.area_mm2;
    for (const provenance::PatchFit& fit : record.patch_fits)
      if (fit.patch == p) row.distances = distances_of(fit);
    page.patches.push_back(std::move(row));
  }
}

void add_swaps(const Record& record, report::ScanReport& page) {
  const auto of = [&](const std::string& name) { return figure(record, "optimise", name); };
  const auto whole = [&](const std::string& name) { return count(record, "optimise", name); };
  for (const std::string pass : {"smooth", "feature"})
    if (has_figure(record, "optimise", pass + "_rounds"))
      page.swaps.push_back({pass, whole(pass + "_rounds"), whole(pass + "_swaps"), of(pass + "_angle_p5_before_deg"),
                            of(pass + "_angle_p5_after_deg")});
  if (!has_figure(record, "optimise", "feature_rounds")) return;
  const auto creases = [&](const std::string& when) {
    return report::Creases{of("dihedral_sum_deg_" + when), of("normal_variation_rms_" + when),
                           of("sharp_length_mm_" + when), whole("sharp_edges_" + when)};
  };
  page.creases_before = creases("before_feature");
  page.creases_after = creases("after_feature");
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

void add_files(const Record& record, const std::vector<WrittenFile>& files, report::ScanReport& page) {
  for (const provenance::InputEntry& input : record.inputs) {
    report::InputFile& file = page.inputs.emplace_back();
    file.path = input.path;
    file.missing = input.missing;
    file.format = input.format;
    file.bytes = input.bytes;
    file.points_read = input.points_read;
    file.points_used = input.points_used;
    file.sha256 = input.sha256;
  }
  for (const WrittenFile& output : files) page.outputs.push_back({output.name, output.bytes, output.sha256});
}

}  // namespace

report::ScanReport page_of(const FinishedScan& scan, const What& what, const std::vector<WrittenFile>& files,
                           std::vector<report::Picture> pictures, std::vector<report::SectionRow> sections,
                           const PageFrame& frame) {
  const Record& record = scan.record;
  report::ScanReport page;
  page.scan = record.scan;
  page.job = frame.job;
  page.tool = frame.tool;
  page.record = frame.record;
  page.fit = fit_of(record);
  for (const verify::Gate& gate : verify::gates_of(what.verify, page.fit->all.max_mm, page.fit->all.rms_mm))
    page.gates.push_back({"verify." + gate.name, gate.limit, gate.found, "mm", gate.passed});
  for (std::size_t n = 0; n < record.notes.size(); ++n)
    page.notes.push_back({record.note_kinds[n] == provenance::NoteKind::Warning, record.notes[n]});
  page.pictures = std::move(pictures);
  page.view = view_of(record);
  page.sections = std::move(sections);
  add_points(record, page);
  page.mesh = mesh_of(scan, what);
  add_patches(record, page);
  add_swaps(record, page);
  What defaults;
  defaults.profile = what.profile;
  add_parameters(to_document(what_for(what, record.scan)), to_document(defaults), "", page);
  add_files(record, files, page);
  page.stage_versions = stage_versions();
  page.date = frame.date;
  page.stage_seconds = frame.stage_seconds;
  return page;
}

}  // namespace scanmill::pipeline
