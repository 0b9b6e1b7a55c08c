// SPDX-License-Identifier: Apache-2.0
#include "pipeline/scan_record.hpp"

#include "base/digest.hpp"
#include "export/writers.hpp"
#include "pipeline/mesh_files.hpp"
#include "pipeline/refine_scan.hpp"
#include "pipeline/run_scan.hpp"
#include "store/files.hpp"

namespace scanmill::pipeline {
namespace {

using provenance::Record;

constexpr std::uint64_t kLongestDescription = 64 << 20;

/// Of the rows as the file holds them: a left-handed frame has its z negated.
std::array<double, 16> matrix_of(const Pose& pose, bool mirrored) {
  std::array<double, 16> m = pose.matrix();
  if (mirrored)
    for (const std::size_t at : {2u, 6u, 10u}) m[at] = 0 - m[at];
  return m;
}

void add_inputs(const ScanPoints& points, const std::vector<std::string>& digests, Record& record) {
  const std::vector<ViewSpec>& views = points.specs();
  record.inputs.resize(views.size());
  for (std::size_t v = 0; v < views.size(); ++v) {
    record.inputs[v].path = views[v].path;
    record.inputs[v].missing = views[v].missing;
    record.inputs[v].pose = matrix_of(views[v].pose, views[v].mirrored);
    record.inputs[v].units_mm = points.units_mm();
  }
  const std::vector<ViewCounts> counts = points.counts();
  for (std::size_t k = 0; k < points.views().size(); ++k) {
    const OpenView& view = points.views()[k];
    provenance::InputEntry& entry = record.inputs[index_of(view.id)];
    entry.sha256 = digests[k];
    entry.bytes = view.stamp.size;
    entry.format = view.header.format;
    entry.row_meaning = formats::name_of(view.header.row_meaning);
    entry.pose = matrix_of(view.pose, views[index_of(view.id)].mirrored);
    entry.points_read = counts[k].points_read;
    entry.points_used = counts[k].kept();
    entry.not_finite = counts[k].not_finite;
    entry.sensor_invalid = counts[k].sensor_invalid;
  }
}

void add_reduced(const reduce::Reduction& reduction, Record& record) {
  const reduce::ReducedCloud& cloud = reduction.cloud;
  record.bin_mm = cloud.lattice.edge_mm;
  record.lattice_origin = cloud.lattice.origin;
  record.points = cloud.measured;
  record.source = cloud.source;
  record.bins.resize(cloud.size());
  record.drop.resize(cloud.size());
  for (std::size_t row = 0; row < cloud.size(); ++row) {
    const BinKey key = cloud.key(row);
    record.bins[row] = {key.i, key.j, key.k};
    record.drop[row] = static_cast<std::uint8_t>(cloud.drop[row]);
  }
  record.drop_names = drop_names();
}

void add_surface(const MeshedSurface& surface, Record& record) {
  record.mesh = &surface.mesh;
  record.vertex_row = surface.vertex_row;
  for (const grow::Patch& patch : surface.patches.patches)
    record.patches.push_back(
        {patch.seed, grow::name_of(patch.origin), patch.triangles, patch.area_mm2, patch.border_mm});
  record.patch_borders = surface.borders;
  record.growth_rank = surface.patches.rank;
  record.loops = surface.loops;
  record.stray_rows = surface.stray_rows;
  for (const merge::Stray& stray : surface.strays)
    record.strays.push_back(
        {stray.triangles, stray.vertices, (stray.bounds.low + stray.bounds.high) * 0.5, stray.bounds.size()});
}

void add_counters(const reduce::Report& reduced, const MeshedSurface& surface, Record& record) {
  auto add = [&](const char* stage, const char* name, double value, bool integer = true) {
    record.counters.push_back({stage, name, value, integer});
  };
  auto count = [&](const char* stage, const char* name, std::uint64_t value) {
    add(stage, name, static_cast<double>(value));
  };
  count("read", "points_read", reduced.points_read);
  count("read", "not_finite", reduced.not_finite);
  count("read", "sensor_invalid", reduced.sensor_invalid);
  count("reduce", "points_used", reduced.points_used);
  count("reduce", "bins", reduced.bins);
  count("reduce", "dropped_too_few", reduced.dropped_too_few);
  count("reduce", "dropped_isolated", reduced.dropped_isolated);
  count("reduce", "dropped_centre_distance", reduced.dropped_centre_distance);
  count("reduce", "dropped_neighbour_distance", reduced.dropped_neighbour_distance);
  count("reduce", "kept", reduced.kept);
  add("reduce", "median_residual_bins", reduced.median_residual, false);
  add("reduce", "noise_bins", reduced.noise, false);
  count("reduce", "frame_radius_bins", static_cast<std::uint64_t>(reduced.frame_radius));
  const stars::Report& stars = surface.stars;
  count("stars", "confirmed", stars.confirmed);
  count("stars", "candidates", stars.candidates);
  count("stars", "candidates_added", stars.candidates_added);
  count("stars", "turned_back_sector", stars.turned_back_sector);
  count("stars", "turned_back_fold", stars.turned_back_fold);
  count("stars", "turned_back_crossing", stars.turned_back_crossing);
  count("stars", "loops_found", stars.loops_found);
  count("stars", "loops_filled", stars.loops_filled);
  count("stars", "triangles_filled", stars.triangles_filled);
  count("stars", "points_revived", stars.points_revived);
  count("stars", "repairs_tried", stars.repairs_tried);
  count("stars", "repairs_kept", stars.repairs_kept);
  count("stars", "peeled", stars.peeled);
  count("stars", "crossings_cut", stars.crossings_cut);
  count("grow", "refused_range_g1", surface.refused.range);
  count("grow", "refused_angle_g2", surface.refused.angle);
  count("grow", "refused_normal_g3", surface.refused.normal);
  count("grow", "refused_overlap", surface.refused_overlap);
  count("grow", "patches", surface.patches.patches.size());
  count("merge", "components", surface.components);
  count("merge", "strays", surface.strays.size());
  count("merge", "kept_points_used", surface.kept_used);
  count("merge", "points_in_strays", surface.kept_in_strays);
}

void add_swap_counters(const optimise::Report& swaps, Record& record) {
  auto add = [&](const std::string& name, double value, bool integer) {
    record.counters.push_back({"optimise", name, value, integer});
  };
  auto add_pass = [&](const std::string& name, const optimise::PassReport& pass) {
    if (!pass.done) return;
    auto count = [&](const char* what, std::uint64_t value) { add(name + what, static_cast<double>(value), true); };
    count("_rounds", pass.rounds);
    count("_swaps", pass.swaps);
    count("_refused_patch_border", pass.refused.patch_border);
    count("_refused_not_convex", pass.refused.not_convex);
    count("_refused_range_g1", pass.refused.range);
    count("_refused_angle_g2", pass.refused.angle);
    count("_refused_fold", pass.refused.fold);
    count("_refused_edge_exists", pass.refused.edge_exists);
    count("_refused_crossing", pass.refused.crossing);
    add(name + "_angle_p5_before_deg", pass.angle_p5_before_deg, false);
    add(name + "_angle_p5_after_deg", pass.angle_p5_after_deg, false);
  };
  add_pass("smooth", swaps.smooth);
  add_pass("feature", swaps.feature);
  if (!swaps.feature.done) return;
  auto add_creases = [&](const std::string& when, const optimise::Creases& creases) {
    add("dihedral_sum_deg_" + when, creases.dihedral_sum_deg, false);
    add("sharp_edges_" + when, static_cast<double>(creases.sharp_edges), true);
    add("sharp_length_mm_" + when, creases.sharp_length_mm, false);
    add("normal_variation_rms_" + when, creases.normal_variation_rms, false);
  };
  add_creases("before_feature", swaps.before_feature);
  add_creases("after_feature", swaps.after_feature);
}

void add_fit_counters(const verify::Quality& quality, const verify::Report& fit, Record& record) {
  auto add = [&](const std::string& name, double value) { record.counters.push_back({"verify", name, value, false}); };
  auto count = [&](const char* name, std::uint64_t value) {
    record.counters.push_back({"verify", name, static_cast<double>(value), true});
  };
  const TopologyCounts& topology = quality.topology;
  count("points_near", fit.points_near);
  count("vertices", topology.vertices_used);
  count("triangles", topology.triangles);
  count("edges", topology.edges);
  count("boundary_edges", topology.boundary_edges);
  count("boundary_loops", topology.boundary_loops);
  count("components", topology.components);
  count("nonmanifold_edges", topology.nonmanifold_edges);
  count("nonmanifold_vertices", topology.nonmanifold_vertices);
  count("misoriented_edges", topology.misoriented_edges);
  count("degenerate_triangles", quality.repeated_corners + quality.zero_area_triangles);
  count("crossing_pairs", quality.crossing_pairs);
  record.counters.push_back({"verify", "euler", static_cast<double>(topology.euler), true});
  add("smallest_angle_deg", quality.angles.least);
  add("smallest_angle_p5_deg", quality.angles.p5);
  add("longest_edge_mm", quality.edges.greatest);
  add("area_mm2", quality.area_mm2);
  add("volume_mm3", quality.volume_mm3);
  auto add_distances = [&](const std::string& name, const verify::DistanceFigures& d) {
    record.counters.push_back({"verify", name + "points", static_cast<double>(d.count), true});
    add(name + "max_mm", d.max_mm);
    add(name + "rms_mm", d.rms_mm);
    add(name + "mean_mm", d.mean_mm);
    add(name + "signed_mean_mm", d.signed_mean_mm);
    add(name + "above_mm", d.above_mm);
    add(name + "below_mm", d.below_mm);
    if (!d.percentiles) return;
    add(name + "p50_mm", d.percentiles->p50);
    add(name + "p90_mm", d.percentiles->p90);
    add(name + "p95_mm", d.percentiles->p95);
    add(name + "p99_mm", d.percentiles->p99);
    add(name + "p99_9_mm", d.percentiles->p999);
  };
  add_distances("", fit.all);
  add_distances("interior_", fit.interior);
  add_distances("open_border_", fit.open_border);
  add_distances("patch_border_", fit.patch_borders);
  add("fit_error_mm", fit.fit_error_mm);
  add("sensor_accuracy_mm", fit.sensor_accuracy_mm);
  add("total_error_mm", fit.total_error_mm);
  count("triangles_with_points", fit.coverage.triangles_near);
}

void add_distances(const verify::Report& fit, Record& record) {
  for (const verify::PatchFigures& patch : fit.patches) {
    const verify::DistanceFigures& d = patch.distances;
    record.patch_fits.push_back(
        {patch.patch, d.count, d.max_mm, d.rms_mm, d.mean_mm, d.signed_mean_mm, d.above_mm, d.below_mm});
  }
  auto worst_of = [](const std::vector<verify::WorstPoint>& from) {
    std::vector<provenance::WorstEntry> to;
    for (const verify::WorstPoint& w : from) to.push_back({w.place, w.signed_mm, w.source, w.patch, w.open_border});
    return to;
  };
  record.worst = worst_of(fit.worst);
  record.worst_interior = worst_of(fit.worst_interior);
  record.histogram.push_back(fit.histogram.below);
  record.histogram.insert(record.histogram.end(), fit.histogram.counts.begin(), fit.histogram.counts.end());
  record.histogram.push_back(fit.histogram.above);
}

/// Versions of the stages that this engine runs.
std::vector<std::pair<std::string, std::string>> stage_versions_of(Engine engine) {
  auto versions = stage_versions();
  const char* other = engine == Engine::Front ? "stars" : "front";
  std::erase_if(versions, [&](const auto& row) { return row.first == other; });
  return versions;
}

}  // namespace

std::vector<std::string> drop_names() {
  return {"kept", "too few points", "isolated", "centre distance (c1)", "neighbour distance (c2)"};
}

Result<void> add_description(const std::string& archive, const ScanSpec& scan, Record& record) {
  if (scan.description.empty()) return {};
  TRY_ASSIGN(const auto source, store::open_file(archive + "/" + scan.description, scan.description));
  TRY_ASSIGN(record.description_text, read_all(*source, kLongestDescription));
  record.description_path = scan.description;
  record.description_sha256 = sha256_hex(record.description_text);
  return {};
}

Result<Record> record_of(const ScanResults& results) {
  Record record;
  record.scan = results.scan.name;
  TRY(add_description(results.archive, results.scan, record));
  add_inputs(results.points, results.digests, record);
  add_reduced(results.reduction, record);
  add_surface(results.surface, record);
  VertexErrors errors = vertex_errors(results.fit);
  record.vertex_error = std::move(errors.signed_mm);
  record.vertex_error_rms = std::move(errors.rms_mm);
  if (results.refined != nullptr) add_refinement(*results.refined, results.points, record);
  add_clean_counters(results.cleaned, record);
  add_counters(results.reduction.report, results.surface, record);
  add_swap_counters(results.swaps, record);
  add_fit_counters(results.quality, results.fit, record);
  record.counters.push_back({"verify", "points_in_strays", static_cast<double>(results.points_in_strays), true});
  add_distances(results.fit, record);
  record.notes = results.notes.texts;
  record.note_kinds = results.notes.kinds;
  record.stage_versions = stage_versions_of(results.what.grow.engine);
  record.stl_header = exporting::stl_header(results.surface.mesh.offset);
  return record;
}

namespace {
const provenance::Counter* counter_of(const Record& record, std::string_view stage, std::string_view name) {
  for (const provenance::Counter& counter : record.counters)
    if (counter.name == name && counter.stage == stage) return &counter;
  return nullptr;
}
}  // namespace

double figure(const Record& record, std::string_view stage, std::string_view name) {
  const provenance::Counter* counter = counter_of(record, stage, name);
  return counter ? counter->value : 0;
}

std::uint64_t count(const Record& record, std::string_view stage, std::string_view name) {
  return static_cast<std::uint64_t>(figure(record, stage, name));
}

bool has_figure(const Record& record, std::string_view stage, std::string_view name) {
  return counter_of(record, stage, name) != nullptr;
}

void set_figure(Record& record, std::string_view stage, std::string_view name, double value) {
  for (provenance::Counter& counter : record.counters)
    if (counter.name == name && counter.stage == stage) counter.value = value;
}

}  // namespace scanmill::pipeline
