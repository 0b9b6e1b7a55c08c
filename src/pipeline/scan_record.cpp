// SPDX-License-Identifier: Apache-2.0
#include "pipeline/scan_record.hpp"

#include "base/digest.hpp"
#include "export/writers.hpp"
#include "pipeline/run_scan.hpp"
#include "store/files.hpp"

namespace scanmill::pipeline {
namespace {

using provenance::Record;

constexpr std::uint64_t kLongestDescription = 64 << 20;

Result<void> add_description(const std::string& archive, const ScanSpec& scan, Record& record) {
  if (scan.description.empty()) return {};
  TRY_ASSIGN(const auto source, store::open_file(archive + "/" + scan.description, scan.description));
  TRY_ASSIGN(record.description_text, read_all(*source, kLongestDescription));
  record.description_path = scan.description;
  record.description_sha256 = sha256_hex(record.description_text);
  return {};
}

void add_inputs(const ScanPoints& points, const std::vector<std::string>& digests, Record& record) {
  const std::vector<ViewSpec>& views = points.specs();
  record.inputs.resize(views.size());
  for (std::size_t v = 0; v < views.size(); ++v) {
    record.inputs[v].path = views[v].path;
    record.inputs[v].missing = views[v].missing;
    record.inputs[v].pose = views[v].pose.matrix();
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
    entry.pose = view.pose.matrix();
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
  const TopologyCounts topology = topology_of(surface.mesh);
  count("mesh", "vertices", topology.vertices_used);
  count("mesh", "triangles", topology.triangles);
  count("mesh", "edges", topology.edges);
  count("mesh", "boundary_edges", topology.boundary_edges);
  count("mesh", "boundary_loops", surface.loops.size());
  count("mesh", "nonmanifold_edges", topology.nonmanifold_edges);
  count("mesh", "nonmanifold_vertices", topology.nonmanifold_vertices);
  count("mesh", "misoriented_edges", topology.misoriented_edges);
  add("mesh", "euler", static_cast<double>(topology.euler));
}

}  // namespace

std::vector<std::string> drop_names() {
  return {"kept", "too few points", "isolated", "centre distance (c1)", "neighbour distance (c2)"};
}

Result<Record> record_of(const std::string& archive, const ScanSpec& scan, const What& what, const ScanPoints& points,
                         const std::vector<std::string>& digests, const reduce::Reduction& reduction,
                         const MeshedSurface& surface, const std::vector<std::string>& notes,
                         const std::string& stl_digest) {
  Record record;
  record.scan = scan.name;
  record.what_json = document::to_canonical_json(to_document(what_for(what, scan.name)));
  TRY(add_description(archive, scan, record));
  add_inputs(points, digests, record);
  add_reduced(reduction, record);
  add_surface(surface, record);
  add_counters(reduction.report, surface, record);
  record.notes = notes;
  record.stage_versions = stage_versions();
  record.stl_header = exporting::stl_header();
  record.outputs = {{"mesh.stl", stl_digest}};
  return record;
}

}  // namespace scanmill::pipeline
