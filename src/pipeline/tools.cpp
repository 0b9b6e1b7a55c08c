// SPDX-License-Identifier: Apache-2.0
#include "pipeline/tools.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "base/text.hpp"
#include "export/writers.hpp"
#include "formats/probe.hpp"
#include "pipeline/cloud_measure.hpp"
#include "pipeline/density.hpp"
#include "pipeline/init_job.hpp"
#include "pipeline/outputs_key.hpp"
#include "pipeline/read_order.hpp"
#include "pipeline/reduced_file.hpp"
#include "pipeline/scan_points.hpp"
#include "pipeline/surface.hpp"
#include "pipeline/tool_inputs.hpp"
#include "pipeline/watched_points.hpp"
#include "store/files.hpp"

namespace scanmill::pipeline {
namespace {

using document::Node;

void report_reduction(const reduce::Report& reduced, Node& out) {
  out.set("points_read", reduced.points_read);
  out.set("not_finite", reduced.not_finite);
  out.set("points_used", reduced.points_used);
  out.set("bin_mm", reduced.bin_mm);
  out.set("bins", reduced.bins);
  out.set("dropped_too_few", reduced.dropped_too_few);
  out.set("dropped_isolated", reduced.dropped_isolated);
  out.set("dropped_c1", reduced.dropped_centre_distance);
  out.set("dropped_c2", reduced.dropped_neighbour_distance);
  out.set("kept", reduced.kept);
  out.set("median_residual_bins", reduced.median_residual);
}

void report_surface(const MeshedSurface& surface, Node& out) {
  const TopologyCounts counts = topology_of(surface.mesh);
  out.set("vertices", counts.vertices_used);
  out.set("triangles", counts.triangles);
  out.set("components", counts.components);
  out.set("patches", static_cast<std::uint64_t>(surface.patches.patches.size()));
  out.set("boundary_loops", static_cast<std::uint64_t>(surface.loops.size()));
  out.set("boundary_edges", counts.boundary_edges);
  out.set("nonmanifold_edges", counts.nonmanifold_edges);
  out.set("nonmanifold_vertices", counts.nonmanifold_vertices);
  out.set("misoriented_edges", counts.misoriented_edges);
  out.set("refused_g1", surface.refused.range);
  out.set("refused_g2", surface.refused.angle);
  out.set("refused_g3", surface.refused.normal);
  out.set("kept_points_used", surface.kept_used);
  out.set("stray_components", static_cast<std::uint64_t>(surface.strays.size()));
  out.set("points_in_strays", surface.kept_in_strays);
  if (!(surface.mesh.offset == Vec3{})) out.set("offset_mm", triple(surface.mesh.offset));
}

/// Notes of the scan and of every file of it, and what is to be said of bins finer than the points allow.
void add_notes(const OpenedInputs& opened, Node& out, const reduce::ReducedCloud* cloud = nullptr) {
  std::vector<std::string> notes = opened.input.scan.notes;
  for (const OpenView& view : opened.points->views())
    for (const std::string& note : view.header.notes) notes.push_back(view.path + ": " + note);
  if (std::string note = cloud != nullptr ? fine_bins_note(*cloud) : std::string(); !note.empty())
    notes.push_back(std::move(note));
  if (!notes.empty()) out.set("notes", texts(notes));
}

Result<reduce::Reduction> reduce_inputs(const OpenedInputs& opened, const What& what, const Context& context,
                                        Progress& progress) {
  TRY_ASSIGN(const auto gathered, gathered_if_scattered(*opened.points, what.lattice, what.reduce, context, progress));
  const WatchedPoints watched(gathered ? *gathered : *opened.points, "reduce", progress);
  auto reduced = reduce::reduce_cloud(watched, what.lattice, what.reduce, context);
  if (!reduced.ok()) return as_typed(std::move(reduced).error(), opened.input);
  reduce::Reduction reduction = std::move(reduced).value();
  const reduce::Report& seen = reduction.report;
  std::string problem = implausible_size(seen.bounds, opened.points->units_mm(), seen.bin_mm, seen.points_used);
  if (!problem.empty()) return as_typed(fail(Code::BadInput, std::move(problem)), opened.input);
  return reduction;
}

/// Bounds of a file that `reduce` wrote: its points are all that is known.
Bounds bounds_of(const reduce::ReducedCloud& cloud) {
  Bounds bounds;
  for (const Vec3 p : cloud.measured) bounds.add(p);
  return bounds;
}

bool is_mesh_suffix(const std::string& suffix) {
  const auto words = mesh_suffixes();
  return std::find(words.begin(), words.end(), suffix) != words.end();
}

}  // namespace

Result<ToolReport> reduce_to_file(const std::vector<std::string>& inputs, const What& what, const std::string& output,
                                  const Context& context, Progress& progress) {
  TRY(check_output(output, {".ply"}, inputs));
  TRY_ASSIGN(const OpenedInputs opened, open_inputs(inputs, what));
  TRY_ASSIGN(const reduce::Reduction reduction, reduce_inputs(opened, what, context, progress));
  if (reduction.report.kept == 0)
    return as_typed(fail(Code::BadInput, "no point of " + std::to_string(reduction.report.points_used) +
                                             " can be kept with bins of " + number_text(reduction.report.bin_mm) +
                                             " mm; choose larger bins or check the units"),
                    opened.input);
  TRY_ASSIGN(auto sink, store::create_file(output));
  TRY(write_reduced(reduction.cloud, *sink));
  TRY(opened.points->verify_unchanged());
  TRY(sink->commit());
  ToolReport report;
  report.values.set("file", output);
  report_reduction(reduction.report, report.values);
  add_notes(opened, report.values, &reduction.cloud);
  return report;
}

Result<ToolReport> mesh_to_file(const std::vector<std::string>& inputs, const What& what, bool as_is,
                                const std::string& output, const Context& context, Progress& progress) {
  TRY(check_output(output, {".stl"}, inputs));
  ToolReport report;
  report.values.set("file", output);
  reduce::ReducedCloud cloud;
  Bounds bounds;
  if (as_is) {
    if (inputs.size() != 1) return fail(Code::BadUsage, "--as-is takes one file that `scanmill reduce` wrote");
    TRY_ASSIGN(const auto source, store::open_file(inputs.front(), inputs.front()));
    TRY_ASSIGN(cloud, read_reduced(*source));
    if (what.lattice.bin_mm && *what.lattice.bin_mm != cloud.lattice.edge_mm)
      return fail(Code::BadUsage,
                  "was reduced with bins of " + number_text(cloud.lattice.edge_mm) + " mm, found bin_mm " +
                      number_text(*what.lattice.bin_mm) + "; leave it away with --as-is, or reduce again",
                  inputs.front());
    bounds = bounds_of(cloud);
    report.values.set("bin_mm", cloud.lattice.edge_mm);
  } else {
    TRY_ASSIGN(const OpenedInputs opened, open_inputs(inputs, what));
    TRY_ASSIGN(reduce::Reduction reduction, reduce_inputs(opened, what, context, progress));
    TRY(opened.points->verify_unchanged());
    report_reduction(reduction.report, report.values);
    add_notes(opened, report.values, &reduction.cloud);
    cloud = std::move(reduction.cloud);
    bounds = reduction.report.bounds;
  }
  auto meshed = mesh_surface(cloud, bounds, what, context, progress);
  if (!meshed.ok()) {
    Error error = std::move(meshed).error();
    return error.where.empty() ? std::move(error).at(inputs.front()) : error;
  }
  const MeshedSurface surface = std::move(meshed).value();
  TRY_ASSIGN(auto sink, store::create_file(output));
  TRY(exporting::write_stl(surface.mesh, *sink));
  TRY(sink->commit());
  report_surface(surface, report.values);
  return report;
}

Result<ToolReport> cloud_info(const std::string& input, const What& what, const Context& context, Progress& progress) {
  TRY_ASSIGN(const OpenedInputs opened, open_inputs({input}, what));
  const ScanPoints& points = *opened.points;
  const WatchedPoints watched(points, "info", progress);
  const auto measured = measure_cloud(watched, context);
  if (!measured.ok()) return as_typed(measured.error(), opened.input);
  const CloudMeasure& seen = *measured;
  ToolReport report;
  Node& out = report.values;
  out.set("file", input);
  Node views = Node::sequence();
  const std::vector<ViewCounts> counts = points.counts();
  for (std::size_t k = 0; k < points.views().size(); ++k) {
    const OpenView& view = points.views()[k];
    Node entry = Node::map();
    entry.set("path", view.path);
    entry.set("format", view.header.format);
    entry.set("points", counts[k].points_read);
    entry.set("not_finite", counts[k].not_finite);
    if (counts[k].sensor_invalid > 0) entry.set("sensor_invalid", counts[k].sensor_invalid);
    if (!view.header.notes.empty()) entry.set("notes", texts(view.header.notes));
    views.push(std::move(entry));
  }
  out.set("views", std::move(views));
  out.set("units_mm", points.units_mm());
  out.set("points", seen.points_read);
  out.set("finite", seen.points_used);
  out.set("low_mm", triple(seen.bounds.low));
  out.set("high_mm", triple(seen.bounds.high));
  out.set("size_mm", triple(seen.bounds.size()));
  if (seen.spacing_mm)
    out.set("spacing_mm", *seen.spacing_mm);
  else
    out.set("spacing_mm", "fewer than 100 points: too few to tell");
  if (std::string problem = implausible_size(seen.bounds, points.units_mm(), 0, seen.points_used); !problem.empty())
    out.set("warning", problem);
  if (seen.noise_mm) out.set("noise_mm_at_most", *seen.noise_mm);  // curvature and misregistration are in it
  if (seen.suggested_bin_mm) out.set("suggested_bin_mm", *seen.suggested_bin_mm);
  if (!opened.input.scan.notes.empty()) out.set("notes", texts(opened.input.scan.notes));
  return report;
}

Result<ToolReport> convert_cloud(const std::string& input, const What& what, const std::string& output,
                                 const Context& context, Progress& progress) {
  TRY_ASSIGN(const OpenedInputs opened, open_inputs({input}, what));
  if (const std::string suffix = formats::suffix_of(output); is_mesh_suffix(suffix) && suffix != "ply")
    return fail(Code::BadUsage,
                input + " is read as a cloud, and a ." + suffix + " file holds triangles; make a mesh of it first " +
                    "(scanmill run, or scanmill mesh " + input + " -o mesh.stl), or write the points as .ply",
                output);
  TRY(check_output(output, {".ply"}, {input}));
  const ScanPoints& points = *opened.points;
  std::uint64_t count = 0;
  PointBlock block;
  for (std::size_t number = 0; number < points.block_count(); ++number) {
    if (context.cancel.is_set()) return fail(Code::Cancelled, "stopped on request", output);
    TRY(points.read_block(number, block));
    count += block.positions.size();
  }
  if (count == 0)
    return as_typed(fail(Code::BadInput, "no finite point to convert; nothing was written"), opened.input);
  TRY_ASSIGN(auto sink, store::create_file(output));
  std::vector<std::string> comments{"scanmill convert: global frame, mm"};
  for (const OpenView& view : points.views())
    comments.push_back("view " + std::to_string(index_of(view.id)) + " " + view.path);
  TRY_ASSIGN(exporting::PlyPointWriter writer, exporting::PlyPointWriter::begin(*sink, count, comments));
  std::uint64_t done = 0;
  for (std::size_t number = 0; number < points.block_count(); ++number) {
    if (context.cancel.is_set()) return fail(Code::Cancelled, "stopped on request", output);
    TRY(points.read_block(number, block));
    TRY(writer.add(block));
    progress.stage("convert", done += block.positions.size(), count);
  }
  TRY(writer.finish());
  TRY(points.verify_unchanged());
  TRY(sink->commit());
  ToolReport report;
  report.values.set("file", output);
  report.values.set("points", count);
  std::uint64_t dropped = 0;
  for (const ViewCounts& counts : points.counts()) dropped += counts.not_finite + counts.sensor_invalid;
  report.values.set("not_finite_dropped", dropped);
  report.values.set("views", static_cast<std::uint64_t>(points.views().size()));
  add_notes(opened, report.values);
  return report;
}

Result<ToolReport> write_first_job(const std::string& archive, const std::string& output, const Context& context,
                                   Progress& progress) {
  namespace fs = std::filesystem;
  if (!store::is_folder(archive)) return fail(Code::BadUsage, "found no folder; wanted an archive of scans", archive);
  const fs::path folder = fs::absolute(output).parent_path();
  std::string name = fs::absolute(archive).lexically_normal().lexically_relative(folder.lexically_normal()).string();
  while (name.size() > 1 && name.back() == '/') name.pop_back();
  if (store::exists(output))
    return fail(Code::BadUsage, "is there already; name another file with -o, nothing was written", output);
  TRY_ASSIGN(const FirstJob job, first_job(archive, name.empty() ? "." : name, context, progress));
  TRY(store::write_text(output, job.text));
  ToolReport report;
  report.values.set("file", output);
  report.values.set("scans", static_cast<std::uint64_t>(job.scans));
  report.values.set("measured", static_cast<std::uint64_t>(job.measured));
  report.values.set("next", "scanmill run " + output);
  return report;
}

}  // namespace scanmill::pipeline
