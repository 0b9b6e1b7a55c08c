// SPDX-License-Identifier: Apache-2.0
#include "pipeline/mesh_tools.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "base/text.hpp"
#include "formats/mesh_reader.hpp"
#include "formats/probe.hpp"
#include "optimise/optimise.hpp"
#include "pipeline/convert_notes.hpp"
#include "pipeline/judge_scan.hpp"
#include "pipeline/mesh_files.hpp"
#include "pipeline/section_files.hpp"
#include "pipeline/sections_key.hpp"
#include "pipeline/surface.hpp"
#include "pipeline/tool_inputs.hpp"
#include "pipeline/unit_hint.hpp"
#include "pipeline/watched_points.hpp"
#include "render/render.hpp"
#include "store/files.hpp"
#include "verify/compare.hpp"
#include "verify/verify.hpp"

namespace scanmill::pipeline {
namespace {

using document::Node;

constexpr double kFarShare = 0.1, kOffShare = 0.001;  // of a mesh's diagonal
constexpr std::uint64_t kDrawn = 4'000'000;  // points of a cloud in a picture; evenly spread rows of larger ones

struct LoadedMesh {
  formats::MeshFile file;
  Mesh mesh;  // mm
};

Result<LoadedMesh> load_mesh(const std::string& path, const What& what) {
  TRY_ASSIGN(auto source, store::open_file(path, path));
  LoadedMesh loaded;
  TRY_ASSIGN(loaded.file, formats::read_mesh(std::move(source)));
  if (loaded.file.triangles.empty())
    return fail(Code::BadInput, "holds no triangle; wanted a mesh (STL, OBJ, OFF or PLY with faces)", path);
  loaded.mesh = formats::mesh_of(loaded.file);
  if (what.units_mm != 1) {
    for (Vec3& p : loaded.mesh.positions) p = p * what.units_mm;
    loaded.mesh.offset = loaded.mesh.offset * what.units_mm;
  }
  return loaded;
}

void report_quality(const verify::Quality& q, Node& out) {
  out.set("vertices", q.topology.vertices_used);
  out.set("unused_vertices", q.vertices_unused);
  out.set("triangles", q.topology.triangles);
  out.set("edges", q.topology.edges);
  out.set("euler", q.topology.euler);
  out.set("components", q.topology.components);
  out.set("boundary_edges", q.topology.boundary_edges);
  out.set("boundary_loops", q.topology.boundary_loops);
  out.set("nonmanifold_edges", q.topology.nonmanifold_edges);
  out.set("nonmanifold_vertices", q.topology.nonmanifold_vertices);
  out.set("misoriented_edges", q.topology.misoriented_edges);
  out.set("orientable", q.orientable);
  out.set("closed_manifold", q.closed_manifold);
  out.set("repeated_corners", q.repeated_corners);
  out.set("zero_area_triangles", q.zero_area_triangles);
  out.set("duplicate_triangles", q.duplicate_triangles);
  out.set("crossing_pairs", q.crossing_pairs);
  out.set("crossing_triangles", q.crossing_triangles);
  out.set("smallest_angle_deg", q.angles.least);
  out.set("smallest_angle_p1_deg", q.angles.p1);
  out.set("smallest_angle_p5_deg", q.angles.p5);
  out.set("smallest_angle_p50_deg", q.angles.p50);
  out.set("shortest_edge_mm", q.edges.least);
  out.set("median_edge_mm", q.edges.p50);
  out.set("longest_edge_mm", q.edges.greatest);
  out.set("area_mm2", q.area_mm2);
  out.set("volume_mm3", q.volume_mm3);
  out.set("low_mm", triple(q.bounds.low));
  out.set("high_mm", triple(q.bounds.high));
  Node loops = Node::sequence();
  for (const BorderLoop& loop : q.loops) {
    Node row = Node::map();
    row.set("length_mm", loop.length_mm);
    row.set("edges", static_cast<std::uint64_t>(loop.vertices.size()));
    row.set("centre_mm", triple(loop.centre));
    loops.push(std::move(row));
  }
  if (!q.loops.empty()) out.set("loops", std::move(loops));
  Node crossings = Node::sequence();
  for (const verify::Crossing& crossing : q.crossings) {
    Node row = Node::map();
    row.set("first", static_cast<std::uint64_t>(crossing.first));
    row.set("second", static_cast<std::uint64_t>(crossing.second));
    row.set("place_mm", triple(crossing.place));
    crossings.push(std::move(row));
  }
  if (!q.crossings.empty()) out.set("crossings", std::move(crossings));
}

Node distances_node(const verify::DistanceFigures& d) {
  Node node = Node::map();
  node.set("points", d.count);
  node.set("max_mm", d.max_mm);
  node.set("rms_mm", d.rms_mm);
  node.set("mean_mm", d.mean_mm);
  node.set("signed_mean_mm", d.signed_mean_mm);
  node.set("above_mm", d.above_mm);
  node.set("below_mm", d.below_mm);
  if (!d.percentiles) return node;
  node.set("p50_mm", d.percentiles->p50);
  node.set("p90_mm", d.percentiles->p90);
  node.set("p95_mm", d.percentiles->p95);
  node.set("p99_mm", d.percentiles->p99);
  node.set("p99_9_mm", d.percentiles->p999);
  return node;
}

/// `unit` is the name of the length that stands in for a bin.
void report_fit(const verify::Report& fit, const ScanPoints& points, const char* unit, Node& out) {
  out.set("points_read", fit.points_read);
  out.set(unit, fit.bin_mm);
  out.set("all", distances_node(fit.all));
  out.set("interior", distances_node(fit.interior));
  out.set("open_border", distances_node(fit.open_border));
  out.set("patch_borders", distances_node(fit.patch_borders));
  Node patches = Node::sequence();
  for (const verify::PatchFigures& patch : fit.patches) {
    Node row = distances_node(patch.distances);
    row.set("patch", static_cast<std::uint64_t>(patch.patch));
    row.set("triangles", patch.triangles);
    patches.push(std::move(row));
  }
  if (fit.patches.size() > 1) out.set("patches", std::move(patches));
  Node worst = Node::sequence();
  for (const verify::WorstPoint& point : fit.worst) {
    Node row = Node::map();
    row.set("place_mm", triple(point.place));
    row.set("signed_mm", point.signed_mm);
    for (const OpenView& view : points.views())
      if (view.id == point.source.view) row.set("file", view.path);
    row.set("row", point.source.row);
    row.set("open_border", point.open_border);
    worst.push(std::move(row));
  }
  out.set("worst", std::move(worst));
  out.set("fit_error_mm", fit.fit_error_mm);
  out.set("sensor_accuracy_mm", fit.sensor_accuracy_mm);
  out.set("total_error_mm", fit.total_error_mm);
  out.set("triangles_with_points", fit.coverage.triangles_near);
  Node gates = Node::sequence();
  for (const verify::Gate& gate : fit.gates) {
    Node row = Node::map();
    row.set("gate", gate.name);
    row.set("limit_mm", gate.limit);
    row.set("found_mm", gate.found);
    row.set("passed", gate.passed);
    gates.push(std::move(row));
  }
  if (!fit.gates.empty()) out.set("gates", std::move(gates));
}

/// The files of the sections into the folder, their figures into `out`.
Result<void> write_cuts(const SectionResults& cuts, const ScanPoints& points, const std::string& folder, Node& out) {
  TRY(store::make_folders(folder));
  TRY_ASSIGN(const std::vector<WrittenFile> sheets, write_section_files(cuts.sections, {Output{"iges"}}, folder));
  TRY_ASSIGN(const auto rows, draw_sections(cuts.sections, folder));
  Node list = Node::sequence(), files = Node::sequence();
  for (const WrittenFile& sheet : sheets) files.push(folder + "/" + sheet.name);
  for (std::size_t n = 0; n < cuts.sections.size(); ++n) {
    const Section& section = cuts.sections[n];
    Node row = Node::map();
    row.set("name", section.frame.name);
    row.set("origin_mm", triple(section.frame.origin));
    row.set("normal", triple(section.frame.normal));
    row.set("length_mm", section.length_mm);
    row.set("slab_mm", section.frame.slab_mm);
    row.set("points", section.points_in_slab);
    row.set("points_at_open_border", section.points_at_open_border);
    row.set("max_mm", section.max_mm);
    row.set("rms_mm", section.rms_mm);
    row.set("magnify", section.magnify);
    if (section.worst) {
      Node worst = Node::map();
      worst.set("place_mm", triple(section.worst->place));
      worst.set("signed_mm", section.worst->signed_mm);
      for (const OpenView& view : points.views())
        if (view.id == section.worst->source.view) worst.set("file", view.path);
      worst.set("row", section.worst->source.row);
      row.set("worst", std::move(worst));
    }
    list.push(std::move(row));
    files.push(folder + "/section-" + std::to_string(n + 1) + ".png");
  }
  out.set("sections", std::move(list));
  out.set("files", std::move(files));
  if (!cuts.notes.empty()) out.set("notes", texts(cuts.notes));
  return {};
}

double longest_edge(const Mesh& mesh) {
  double longest2 = 0;
  for (const Triangle& t : mesh.triangles)
    for (std::size_t e = 0; e < 3; ++e)
      longest2 = std::max(longest2, norm2(mesh.positions[t[(e + 1) % 3]] - mesh.positions[t[e]]));
  return std::sqrt(longest2);
}

Node pass_node(const optimise::PassReport& pass) {
  Node node = Node::map();
  node.set("rounds", pass.rounds);
  node.set("swaps", pass.swaps);
  node.set("angle_p5_before_deg", pass.angle_p5_before_deg);
  node.set("angle_p5_after_deg", pass.angle_p5_after_deg);
  node.set("longest_edge_mm", pass.longest_edge_mm);
  return node;
}

Node creases_node(const optimise::Creases& creases) {
  Node node = Node::map();
  node.set("dihedral_sum_deg", creases.dihedral_sum_deg);
  node.set("sharp_edges", creases.sharp_edges);
  node.set("sharp_length_mm", creases.sharp_length_mm);
  node.set("normal_variation_rms", creases.normal_variation_rms);
  return node;
}

/// Float32 files of meshes far from the origin: translated as a job's are, so that no digit that matters is lost. The
/// unit is the greatest power of two up to the mean edge, so that the offset has few digits; the file says it.
void move_near_origin(formats::MeshFile& file, Mesh& mesh, double unit_mm, std::vector<std::string>& notes) {
  Bounds bounds;
  double sum = 0;
  for (const Triangle& t : mesh.triangles)
    for (std::size_t e = 0; e < 3; ++e) {
      bounds.add(mesh.positions[t[e]]);
      sum += norm(mesh.positions[t[(e + 1) % 3]] - mesh.positions[t[e]]);
    }
  const double mean = mesh.triangles.empty() ? 0 : sum / (3 * static_cast<double>(mesh.triangles.size()));
  if (!(mean > 0) || !std::isfinite(mean)) return;
  double edge = 1;
  while (edge > mean) edge /= 2;
  while (edge * 2 <= mean) edge *= 2;
  const Vec3 offset = float32_offset(bounds, edge);
  if (offset == Vec3{}) return;
  for (Vec3& p : mesh.positions) p = p - offset;
  for (Vec3& p : file.positions) p = p - offset * (1 / unit_mm);  // so that losses are told of what is written
  mesh.offset = mesh.offset + offset;
  notes.push_back(
      "float32 would cost more than a thousandth of an edge this far from the origin: the mesh is translated by " +
      number_text(0 - offset.x) + " " + number_text(0 - offset.y) + " " + number_text(0 - offset.z) +
      " mm; the file says so as offset_mm");
}

Node side_node(const verify::Side& side) {
  auto deviation = [](const verify::Deviation& d) {
    Node node = Node::map();
    node.set("places", d.places);
    node.set("max_mm", d.max_mm);
    node.set("rms_mm", d.rms_mm);
    node.set("mean_mm", d.mean_mm);
    node.set("p99_mm", d.p99_mm);
    node.set("worst_at_mm", triple(d.worst));
    return node;
  };
  Node node = Node::map();
  node.set("vertices", side.topology.vertices_used);
  node.set("triangles", side.topology.triangles);
  node.set("components", side.topology.components);
  node.set("boundary_loops", side.topology.boundary_loops);
  node.set("area_mm2", side.area_mm2);
  node.set("volume_mm3", side.volume_mm3);
  node.set("from_vertices", deviation(side.vertices));
  node.set("from_surface", deviation(side.surface));
  return node;
}

/// Up to kDrawn points of a cloud, every k-th of each view's rows.
Result<std::vector<Vec3>> sample_of(const ScanPoints& points, const Context& context, Progress& progress) {
  const std::uint64_t step = points.expected_points() / kDrawn + 1;
  std::vector<Vec3> sample;
  PointBlock block;
  for (std::size_t number = 0; number < points.block_count(); ++number) {
    if (context.cancel.is_set()) return fail(Code::Cancelled, "stopped on request");
    progress.stage("read", number, points.block_count());
    TRY(points.read_block(number, block));
    for (std::size_t i = 0; i < block.positions.size(); ++i)
      if (block.rows[i] % step == 0 || sample.empty()) sample.push_back(block.positions[i]);
  }
  return sample;
}

template <class Enum>
Result<Enum> word_of(const std::string& word, std::span<const std::string_view> words, const char* option) {
  const auto at = std::find(words.begin(), words.end(), word);
  if (at != words.end()) return static_cast<Enum>(at - words.begin());
  std::string sentence = "found '" + word + "'; allowed " + document::joined(words);
  if (const std::string_view nearest = nearest_name(word, words); !nearest.empty())
    sentence += "; nearest " + std::string(nearest);
  return fail(Code::BadUsage, sentence, std::string("command line: ") + option);
}

/// `style` empty: the format's default.
Result<Output> output_of(const std::string& path, bool ascii, const std::string& style = {}) {
  Output output{std::string(format_of_suffix(formats::suffix_of(path))), ascii};
  const auto styles = styles_of(output.format);
  if (!styles.empty()) output.style = styles[0];
  if (style.empty()) return output;
  if (styles.empty())
    return fail(Code::BadUsage, "found '" + style + "'; " + output.format + " has no styles", "command line: --style");
  TRY(word_of<std::int32_t>(style, styles, "--style"));
  output.style = style;
  return output;
}

}  // namespace

Result<bool> is_mesh_file(const std::string& path) {
  TRY_ASSIGN(const auto source, store::open_file(path, path));
  TRY_ASSIGN(const formats::MeshKind kind, formats::mesh_kind_of(*source));
  if (kind == formats::MeshKind::None) return false;
  if (kind != formats::MeshKind::Ply) return true;
  TRY_ASSIGN(const formats::Probe probe, formats::probe(*source));
  return probe.has_faces;
}

Result<ToolReport> optimise_file(const std::string& input, const What& what, const std::string& output,
                                 const Context& context, Progress& progress) {
  TRY(check_output(output, {".stl", ".ply", ".obj"}, {input}));
  TRY_ASSIGN(LoadedMesh loaded, load_mesh(input, what));
  progress.stage("optimise", 0, 0);
  const double range = what.lattice.bin_mm ? what.grow.range_bins * *what.lattice.bin_mm : longest_edge(loaded.mesh);
  const optimise::Limits limits{range, cos_of_degrees(what.grow.min_angle_deg)};
  TRY_ASSIGN(const optimise::Report swaps, optimise::optimise(loaded.mesh, what.optimise, limits, context));
  TRY_ASSIGN(const Output form, output_of(output, false));
  TRY_ASSIGN(const WrittenFile written, write_mesh_file(loaded.mesh, form, {}, output));
  ToolReport report;
  report.values.set("file", output);
  report.values.set("sha256", written.sha256);
  report.values.set("range_mm", range);
  if (swaps.smooth.done) report.values.set("smooth", pass_node(swaps.smooth));
  if (swaps.feature.done) {
    report.values.set("feature", pass_node(swaps.feature));
    report.values.set("creases_before", creases_node(swaps.before_feature));
    report.values.set("creases_after", creases_node(swaps.after_feature));
  }
  if (!loaded.file.notes.empty()) report.values.set("notes", texts(loaded.file.notes));
  return report;
}

Result<ToolReport> verify_file(const std::string& mesh_path, const std::vector<std::string>& clouds,
                               const SectionChoice& sections, const What& what, const Context& context,
                               Progress& progress) {
  TRY_ASSIGN(const auto planes, sections_from_words(sections.planes));
  if (planes.empty() != sections.folder.empty())
    return fail(Code::BadUsage,
                planes.empty() ? "a folder is for sections; add --section AXIS=PLACE, such as --section z=12.5"
                               : "sections need a folder for their files; add -o DIR",
                "command line");
  if (!planes.empty() && clouds.empty())
    return fail(Code::BadUsage, "a section shows measured points beside the mesh; add --cloud FILE", "command line");
  TRY_ASSIGN(const LoadedMesh loaded, load_mesh(mesh_path, What()));  // units are the clouds'; meshes are mm
  progress.stage("topology", 0, 0);
  TRY_ASSIGN(const verify::Quality quality, verify::quality_of(loaded.mesh, context));
  ToolReport report;
  report.values.set("file", mesh_path);
  report.values.set("format", loaded.file.format);
  report_quality(quality, report.values);
  if (clouds.empty()) {
    if (what.verify.max_error_mm || what.verify.rms_mm)
      return fail(Code::BadUsage, "a gate needs a cloud to judge by; add --cloud FILE", "command line");
    return report;
  }
  TRY_ASSIGN(const OpenedInputs opened, open_inputs(clouds, what));
  const BoundedPoints bounded(*opened.points);
  const WatchedPoints watched(bounded, "verify", progress);
  verify::Terms terms;
  terms.bin_mm = what.lattice.bin_mm.value_or(quality.edges.p50);
  terms.sensor_accuracy_mm = what.sensor.accuracy_mm;
  TRY_ASSIGN(const verify::Report fit, verify::verify_mesh(loaded.mesh, watched, terms, what.verify, context));
  SectionResults cuts;
  if (!planes.empty()) {
    progress.stage("sections", 0, 0);
    const auto& farthest = fit.worst_interior.empty() ? fit.worst : fit.worst_interior;
    const std::optional<Vec3> worst = farthest.empty() ? std::nullopt : std::optional<Vec3>(farthest[0].place);
    TRY_ASSIGN(cuts, cut_sections(loaded.mesh, border_loops(loaded.mesh), *opened.points, planes, terms.bin_mm, worst,
                                  context));
  }
  TRY(opened.points->verify_unchanged());
  Node distances = Node::map();
  report_fit(fit, *opened.points, what.lattice.bin_mm ? "bin_mm" : "median_edge_mm", distances);
  report.values.set("fit", std::move(distances));
  if (!planes.empty()) TRY(write_cuts(cuts, *opened.points, sections.folder, report.values));
  report.failed_gates = failed_gates(fit.gates);
  const double far = fit.all.percentiles ? fit.all.percentiles->p50 / norm(quality.bounds.size()) : 0;
  const std::string unit = unit_hint(quality.bounds, bounded.bounds(), opened.points->units_mm());
  if (far > kOffShare && !unit.empty())
    report.values.set("warning", unit);
  else if (far > kFarShare)
    report.values.set("warning",
                      "half of the points lie farther from the mesh than a tenth of its size: do units and "
                      "frames of cloud and mesh agree (--units is the clouds')?");
  return report;
}

Result<ToolReport> compare_files(const std::string& a, const std::string& b, const What& what, const Context& context,
                                 Progress& progress) {
  TRY_ASSIGN(const LoadedMesh first, load_mesh(a, what));
  TRY_ASSIGN(const LoadedMesh second, load_mesh(b, what));
  progress.stage("compare", 0, 0);
  TRY_ASSIGN(const verify::Comparison found, verify::compare_meshes(first.mesh, second.mesh, context));
  ToolReport report;
  report.values.set("identical", found.identical);
  report.values.set("same_vertices", found.same_vertices);
  report.values.set("same_triangles", found.same_triangles);
  report.values.set("vertices_in_both", found.vertices_in_both);
  report.values.set("triangles_in_both", found.triangles_in_both);
  report.values.set("area_difference_mm2", found.area_difference_mm2);
  report.values.set("volume_difference_mm3", found.volume_difference_mm3);
  report.values.set("a", side_node(found.a));
  report.values.set("b", side_node(found.b));
  const double ratio = found.a.area_mm2 / found.b.area_mm2;
  if (ratio > 1e4 || ratio < 1e-4)
    report.values.set("warning", "one surface is more than ten thousand times the other: are both in the same unit?");
  return report;
}

Result<ToolReport> mesh_info(const std::string& input, const What& what, const Context& context, Progress& progress) {
  TRY_ASSIGN(const LoadedMesh loaded, load_mesh(input, what));
  progress.stage("info", 0, 0);
  TRY_ASSIGN(const verify::Quality quality, verify::quality_of(loaded.mesh, context));
  ToolReport report;
  report.values.set("file", input);
  report.values.set("format", loaded.file.format);
  report_quality(quality, report.values);
  if (loaded.file.offset) report.values.set("offset_mm", triple(*loaded.file.offset));
  if (!loaded.file.comments.empty()) report.values.set("comments", texts(loaded.file.comments));
  if (!loaded.file.notes.empty()) report.values.set("notes", texts(loaded.file.notes));
  return report;
}

Result<ToolReport> convert_mesh(const std::string& input, const What& what, const MeshForm& form,
                                const std::string& output, const Context& context, Progress& progress) {
  TRY_ASSIGN(const ConvertTarget target, convert_target_of(output, false, form.ascii));
  TRY(check_output(output, {".stl", ".ply", ".obj", ".igs", ".iges", ".dxf", ".3mf"}, {input}));
  TRY_ASSIGN(const Output wanted, output_of(output, form.ascii, form.style));
  TRY_ASSIGN(LoadedMesh loaded, load_mesh(input, what));
  progress.stage("convert", 0, 0);
  VertexErrors errors;
  for (const double error : loaded.file.error) errors.signed_mm.push_back(static_cast<float>(error));
  for (const double error : loaded.file.error_rms) errors.rms_mm.push_back(static_cast<float>(error));
  Mesh mesh = loaded.mesh;
  // Float32 formats hold rounded coordinates; the loss is told below.
  std::vector<std::string> moved;
  if (is_float32(target)) move_near_origin(loaded.file, mesh, what.units_mm, moved);
  if (is_float32(target))
    for (Vec3& p : mesh.positions)
      p = {static_cast<double>(static_cast<float>(p.x)), static_cast<double>(static_cast<float>(p.y)),
           static_cast<double>(static_cast<float>(p.z))};
  std::optional<ScanSurfaces> surfaces;
  if (surfaces_output({wanted})) {
    TRY_ASSIGN(surfaces, fit_mesh_surfaces(mesh, wanted, context));
  }
  TRY_ASSIGN(const WrittenFile written,
             write_mesh_file(mesh, wanted, errors, output, {}, surfaces ? &*surfaces : nullptr));
  ToolReport report;
  report.values.set("file", output);
  report.values.set("sha256", written.sha256);
  report.values.set("vertices", static_cast<std::uint64_t>(mesh.positions.size()));
  report.values.set("triangles", static_cast<std::uint64_t>(mesh.triangles.size()));
  std::vector<std::string> notes = conversion_losses(loaded.file, target, what.units_mm);
  notes.insert(notes.begin(), loaded.file.notes.begin(), loaded.file.notes.end());
  notes.insert(notes.end(), moved.begin(), moved.end());
  notes.insert(notes.end(), written.notes.begin(), written.notes.end());
  if (!notes.empty()) report.values.set("notes", texts(notes));
  return report;
}

Result<ToolReport> render_file(const std::string& input, const What& what, const PictureChoice& choice,
                               const std::string& output, const Context& context, Progress& progress) {
  TRY(check_output(output, {".png"}, {input}));
  TRY_ASSIGN(const bool is_mesh, is_mesh_file(input));
  render::PictureParams params;
  const std::string style = !choice.as.empty() ? choice.as : is_mesh ? "shaded" : "points";
  TRY_ASSIGN(params.style, word_of<render::Style>(style, render::style_words(), "--as"));
  TRY_ASSIGN(params.view, word_of<render::View>(choice.view, render::view_words(), "--view"));
  params.width = choice.width;
  params.height = choice.height;
  params.error_range_mm = choice.error_range_mm;
  params.title = std::filesystem::path(input).filename().string();
  render::Scene scene;
  LoadedMesh loaded;
  std::vector<Vec3> points;
  if (is_mesh) {
    TRY_ASSIGN(loaded, load_mesh(input, what));
    scene.mesh = &loaded.mesh;
    scene.vertex_error = loaded.file.error;
    if (params.style == render::Style::Error && loaded.file.error.empty())
      return fail(Code::BadInput,
                  "holds no error per vertex; give a mesh.ply of a job (outputs: [ply]), which has the property error",
                  input);
    if (params.style == render::Style::Patches && loaded.file.patch.empty())
      return fail(Code::BadInput, "holds no patch numbers; give a mesh.ply of a job (outputs: [ply])", input);
  } else {
    if (params.style != render::Style::Points)
      return fail(Code::BadUsage, "is a cloud and can be drawn as points only, found " + style, input);
    TRY_ASSIGN(const OpenedInputs opened, open_inputs({input}, what));
    TRY_ASSIGN(points, sample_of(*opened.points, context, progress));
    if (points.empty()) return fail(Code::BadInput, "no finite point in the file; nothing to draw", input);
    scene.points = points;
  }
  progress.stage("render", 0, 0);
  TRY_ASSIGN(const render::Image image, render::render(scene, params, context));
  TRY_ASSIGN(auto sink, store::create_file(output));
  TRY(render::write_png(image, *sink));
  TRY(sink->commit());
  ToolReport report;
  report.values.set("file", output);
  report.values.set("as", style);
  report.values.set("view", choice.view);
  return report;
}

}  // namespace scanmill::pipeline
