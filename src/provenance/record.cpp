// SPDX-License-Identifier: Apache-2.0
// The layout of a record, in writing order. schemas/record.schema.json describes it, and docs/record.md is made from that;
// they change together. What is added raises the version of the stage `record`; what changes, the name in `Conventions`.
#include "provenance/record.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "provenance/hdf5_file.hpp"

namespace scanmill::provenance {
namespace {

constexpr const char* kConventions = "scanmill-record-1";
constexpr std::size_t kStlHeaderBytes = 80;
constexpr std::uint8_t kVtkTriangle = 5;

static_assert(sizeof(Vec3) == 3 * sizeof(double) && sizeof(Triangle) == 3 * sizeof(std::uint32_t),
              "rows are written as they lie in memory");

/// One column of a list of structs.
template <class T, class Row, class Get>
std::vector<T> column(const std::vector<Row>& rows, Get get) {
  std::vector<T> values;
  values.reserve(rows.size());
  for (const Row& row : rows) values.push_back(get(row));
  return values;
}

/// Lists of different length as one array of values and the place where each begins (and the last one ends).
struct Ragged {
  std::vector<std::uint64_t> offsets{0};
  std::vector<std::uint32_t> values;
  void add(const std::vector<std::uint32_t>& list) {
    values.insert(values.end(), list.begin(), list.end());
    offsets.push_back(values.size());
  }
};

Result<void> consistent(const Record& r, const std::string& path) {
  const auto wrong = [&](const char* what) {
    return fail(Code::Internal, std::string("the record to be written is inconsistent: ") + what, path);
  };
  if (r.mesh == nullptr) return wrong("no mesh");
  if (r.source.size() != r.points.size() || r.bins.size() != r.points.size() || r.drop.size() != r.points.size())
    return wrong("points, source, bins and drop differ in length");
  if (r.vertex_row.size() != r.mesh->positions.size()) return wrong("vertex_row and mesh vertices differ in length");
  if (r.mesh->patch.size() != r.mesh->triangles.size()) return wrong("patch and mesh triangles differ in length");
  if (!r.growth_rank.empty() && r.growth_rank.size() != r.mesh->triangles.size())
    return wrong("growth_rank and mesh triangles differ in length");
  for (const std::uint32_t row : r.vertex_row)
    if (row >= r.points.size()) return wrong("vertex_row names a row beyond the points");
  for (const SourceKey& key : r.source)
    if (index_of(key.view) >= r.inputs.size()) return wrong("source names a view beyond the inputs");
  for (const WorstEntry& worst : r.worst)
    if (index_of(worst.source.view) >= r.inputs.size()) return wrong("worst names a view beyond the inputs");
  if (!r.note_kinds.empty() && r.note_kinds.size() != r.notes.size()) return wrong("notes and kinds differ in length");
  if (r.stl_header.size() > kStlHeaderBytes) return wrong("stl_header is longer than 80 bytes");
  return {};
}

Result<void> write_root(Hdf5File& file, const Record& r) {
  TRY(file.attribute("/", "Conventions", std::string(kConventions)));
  // The same work by another release is the same record, so its name stays out of the identity.
  TRY(file.attribute("/", "creator", std::string("scanmill ") + SCANMILL_VERSION, false));
  TRY(file.attribute("/", "title", r.scan));
  TRY(file.attribute("/", "units", std::string("mm")));
  return file.attribute("/", "excluded", std::string("times, host, commit: run.json"));
}

/// VTKHDF UnstructuredGrid 1.0: what VTK 9.1 and ParaView 5.11 open; PolyData came only with 2.0.
Result<void> write_vtk(Hdf5File& file, const Record& r) {
  const Mesh& mesh = *r.mesh;
  TRY(file.group("/VTKHDF"));
  TRY(file.attribute("/VTKHDF", "Version", std::array<std::int64_t, 2>{1, 0}));
  TRY(file.attribute("/VTKHDF", "Type", std::string("UnstructuredGrid")));
  const auto count = [](std::size_t n) { return std::vector<std::int64_t>{static_cast<std::int64_t>(n)}; };
  TRY(file.dataset("/VTKHDF/NumberOfPoints", count(mesh.positions.size())));
  TRY(file.dataset("/VTKHDF/NumberOfCells", count(mesh.triangles.size())));
  TRY(file.dataset("/VTKHDF/NumberOfConnectivityIds", count(mesh.triangles.size() * 3)));
  TRY(file.dataset("/VTKHDF/Points", column<Vec3>(mesh.positions, [&](Vec3 p) { return p + mesh.offset; })));
  TRY(file.dataset("/VTKHDF/Types", std::vector<std::uint8_t>(mesh.triangles.size(), kVtkTriangle)));
  std::vector<std::int64_t> ids;
  ids.reserve(mesh.triangles.size() * 3);
  for (std::size_t t = 0; t <= mesh.triangles.size(); ++t) ids.push_back(static_cast<std::int64_t>(3 * t));
  TRY(file.dataset("/VTKHDF/Offsets", ids));
  ids.clear();
  for (const Triangle& triangle : mesh.triangles) ids.insert(ids.end(), triangle.begin(), triangle.end());
  TRY(file.dataset("/VTKHDF/Connectivity", ids));
  TRY(file.group("/VTKHDF/CellData"));
  TRY(file.dataset("/VTKHDF/CellData/patch", mesh.patch));
  if (!r.growth_rank.empty()) TRY(file.dataset("/VTKHDF/CellData/growth_rank", r.growth_rank));
  TRY(file.group("/VTKHDF/PointData"));
  TRY(file.dataset("/VTKHDF/PointData/row", r.vertex_row));
  if (!r.vertex_error.empty()) {
    TRY(file.dataset("/VTKHDF/PointData/error_mm", r.vertex_error));
    TRY(file.dataset("/VTKHDF/PointData/error_rms_mm", r.vertex_error_rms));
  }
  const auto& source = r.source;
  TRY(file.dataset("/VTKHDF/PointData/source_view",
                   column<std::uint32_t>(r.vertex_row, [&](std::uint32_t row) { return index_of(source[row].view); })));
  return file.dataset("/VTKHDF/PointData/source_row",
                      column<std::uint64_t>(r.vertex_row, [&](std::uint32_t row) { return source[row].row; }));
}

Result<void> write_inputs(Hdf5File& file, const Record& r) {
  const auto& in = r.inputs;
  using Entry = InputEntry;
  TRY(file.group("/inputs"));
  TRY(file.texts("/inputs/path", column<std::string>(in, [](const Entry& e) { return e.path; })));
  TRY(file.texts("/inputs/sha256", column<std::string>(in, [](const Entry& e) { return e.sha256; })));
  TRY(file.dataset("/inputs/bytes", column<std::uint64_t>(in, [](const Entry& e) { return e.bytes; })));
  TRY(file.texts("/inputs/format", column<std::string>(in, [](const Entry& e) { return e.format; })));
  TRY(file.texts("/inputs/row_meaning", column<std::string>(in, [](const Entry& e) { return e.row_meaning; })));
  TRY(file.dataset("/inputs/pose", column<std::array<double, 16>>(in, [](const Entry& e) { return e.pose; }), {4, 4}));
  TRY(file.dataset("/inputs/units_mm", column<double>(in, [](const Entry& e) { return e.units_mm; })));
  TRY(file.dataset("/inputs/points_read", column<std::uint64_t>(in, [](const Entry& e) { return e.points_read; })));
  TRY(file.dataset("/inputs/points_used", column<std::uint64_t>(in, [](const Entry& e) { return e.points_used; })));
  TRY(file.dataset("/inputs/not_finite", column<std::uint64_t>(in, [](const Entry& e) { return e.not_finite; })));
  TRY(file.dataset("/inputs/sensor_invalid",
                   column<std::uint64_t>(in, [](const Entry& e) { return e.sensor_invalid; })));
  return file.dataset("/inputs/missing",
                      column<std::uint8_t>(in, [](const Entry& e) -> std::uint8_t { return e.missing; }));
}

Result<void> write_texts(Hdf5File& file, const Record& r) {
  TRY(file.group("/parameters"));
  TRY(file.text("/parameters/what_json", r.what_json));
  TRY(file.group("/description"));
  TRY(file.attribute("/description", "path", r.description_path));
  TRY(file.attribute("/description", "sha256", r.description_sha256));
  return file.text("/description/text", r.description_text);
}

Result<void> write_reduced(Hdf5File& file, const Record& r) {
  TRY(file.group("/reduced"));
  TRY(file.attribute("/reduced", "bin_mm", r.bin_mm));
  TRY(file.attribute("/reduced", "origin_mm", r.lattice_origin));
  TRY(file.dataset("/reduced/points", r.points));
  TRY(file.dataset("/reduced/source_view",
                   column<std::uint32_t>(r.source, [](SourceKey k) { return index_of(k.view); })));
  TRY(file.dataset("/reduced/source_row", column<std::uint64_t>(r.source, [](SourceKey k) { return k.row; })));
  TRY(file.dataset("/reduced/bin", r.bins));
  TRY(file.dataset("/reduced/drop", r.drop));
  return file.attribute("/reduced/drop", "drop_names", std::span<const std::string>(r.drop_names));
}

/// The STL's corner: -0 would give equal points different bytes.
float stl_number(double value) { return static_cast<float>(value) + 0.0f; }

Result<void> write_mesh(Hdf5File& file, const Record& r) {
  const Mesh& mesh = *r.mesh;
  TRY(file.group("/mesh"));
  TRY(file.attribute("/mesh", "offset_mm", mesh.offset));
  std::vector<std::uint8_t> header(r.stl_header.begin(), r.stl_header.end());
  header.resize(kStlHeaderBytes, ' ');
  TRY(file.dataset("/mesh/stl_header", header));
  TRY(file.dataset("/mesh/stl_positions", column<std::array<float, 3>>(mesh.positions, [](Vec3 p) {
                     return std::array<float, 3>{stl_number(p.x), stl_number(p.y), stl_number(p.z)};
                   })));
  TRY(file.dataset("/mesh/triangles", mesh.triangles));
  TRY(file.link("/VTKHDF/CellData/patch", "/mesh/patch"));
  if (!r.growth_rank.empty()) TRY(file.link("/VTKHDF/CellData/growth_rank", "/mesh/growth_rank"));
  return file.link("/VTKHDF/PointData/row", "/mesh/row");
}

Result<void> write_patches(Hdf5File& file, const Record& r) {
  const auto& patches = r.patches;
  using Entry = PatchEntry;
  TRY(file.group("/patches"));
  TRY(file.dataset("/patches/seed", column<Vec3>(patches, [](const Entry& e) { return e.seed; })));
  TRY(file.texts("/patches/origin", column<std::string>(patches, [](const Entry& e) { return e.origin; })));
  TRY(file.dataset("/patches/triangles", column<std::uint64_t>(patches, [](const Entry& e) { return e.triangles; })));
  TRY(file.dataset("/patches/area_mm2", column<double>(patches, [](const Entry& e) { return e.area_mm2; })));
  TRY(file.dataset("/patches/border_mm", column<double>(patches, [](const Entry& e) { return e.border_mm; })));
  Ragged borders;
  for (const auto& polyline : r.patch_borders) borders.add(polyline);
  TRY(file.dataset("/patches/border_offsets", borders.offsets));
  return file.dataset("/patches/border_vertices", borders.values);
}

Result<void> write_loops(Hdf5File& file, const Record& r) {
  Ragged loops;
  for (const BorderLoop& loop : r.loops) loops.add(loop.vertices);
  TRY(file.group("/loops"));
  TRY(file.dataset("/loops/offsets", loops.offsets));
  TRY(file.dataset("/loops/vertices", loops.values));
  TRY(file.dataset("/loops/length_mm", column<double>(r.loops, [](const BorderLoop& l) { return l.length_mm; })));
  TRY(file.dataset("/loops/centre", column<Vec3>(r.loops, [](const BorderLoop& l) { return l.centre; })));
  using Entry = StrayEntry;
  TRY(file.group("/strays"));
  TRY(file.dataset("/strays/triangles", column<std::uint64_t>(r.strays, [](const Entry& e) { return e.triangles; })));
  TRY(file.dataset("/strays/vertices", column<std::uint64_t>(r.strays, [](const Entry& e) { return e.vertices; })));
  TRY(file.dataset("/strays/centre", column<Vec3>(r.strays, [](const Entry& e) { return e.centre; })));
  TRY(file.dataset("/strays/size", column<Vec3>(r.strays, [](const Entry& e) { return e.size; })));
  return file.dataset("/strays/rows", r.stray_rows);
}

Result<void> write_fit(Hdf5File& file, const Record& r) {
  if (r.histogram.empty()) return {};
  TRY(file.group("/fit"));
  TRY(file.dataset("/fit/histogram", r.histogram));
  TRY(file.dataset("/fit/patches", column<std::array<double, 8>>(r.patch_fits, [](const PatchFit& f) {
                     return std::array<double, 8>{static_cast<double>(f.patch),
                                                  static_cast<double>(f.points),
                                                  f.max_mm,
                                                  f.rms_mm,
                                                  f.mean_mm,
                                                  f.signed_mean_mm,
                                                  f.above_mm,
                                                  f.below_mm};
                   })));
  std::vector<WorstEntry> worst = r.worst;
  worst.insert(worst.end(), r.worst_interior.begin(), r.worst_interior.end());
  TRY(file.dataset("/fit/worst", column<std::array<double, 4>>(worst, [](const WorstEntry& e) {
                     return std::array<double, 4>{e.place.x, e.place.y, e.place.z, e.signed_mm};
                   })));
  TRY(file.dataset("/fit/worst_source", column<std::array<std::uint64_t, 4>>(worst, [](const WorstEntry& e) {
                     return std::array<std::uint64_t, 4>{index_of(e.source.view), e.source.row, e.patch, e.open_border};
                   })));
  return file.attribute("/fit/worst", "of_all_points", static_cast<std::int64_t>(r.worst.size()));
}

Result<void> write_sections(Hdf5File& file, const Record& r) {
  if (r.sections.empty()) return {};
  const auto& s = r.sections;
  auto vectors = [&](const char* name, auto&& of) { return file.dataset(name, column<Vec3>(s, of)); };
  auto numbers = [&](const char* name, auto&& of) { return file.dataset(name, column<double>(s, of)); };
  TRY(file.group("/sections"));
  TRY(file.texts("/sections/name", column<std::string>(s, [](const Section& e) { return e.frame.name; })));
  TRY(vectors("/sections/origin", [](const Section& e) { return e.frame.origin; }));
  TRY(vectors("/sections/normal", [](const Section& e) { return e.frame.normal; }));
  TRY(numbers("/sections/slab_mm", [](const Section& e) { return e.frame.slab_mm; }));
  TRY(numbers("/sections/length_mm", [](const Section& e) { return e.length_mm; }));
  TRY(file.dataset("/sections/points", column<std::uint64_t>(s, [](const Section& e) { return e.points_in_slab; })));
  TRY(file.dataset("/sections/points_at_open_border",
                   column<std::uint64_t>(s, [](const Section& e) { return e.points_at_open_border; })));
  TRY(numbers("/sections/max_mm", [](const Section& e) { return e.max_mm; }));
  TRY(numbers("/sections/rms_mm", [](const Section& e) { return e.rms_mm; }));
  const SectionPoint none;
  auto worst = [&](const Section& e) -> const SectionPoint& { return e.worst ? *e.worst : none; };
  TRY(vectors("/sections/worst", [&](const Section& e) { return worst(e).place; }));
  TRY(numbers("/sections/worst_signed_mm", [&](const Section& e) { return worst(e).signed_mm; }));
  TRY(file.dataset("/sections/worst_view",
                   column<std::uint32_t>(s, [&](const Section& e) { return index_of(worst(e).source.view); })));
  TRY(file.dataset("/sections/worst_row",
                   column<std::uint64_t>(s, [&](const Section& e) { return worst(e).source.row; })));
  std::vector<std::uint32_t> of_line;
  std::vector<std::uint8_t> closed;
  std::vector<std::uint64_t> offsets{0};
  std::vector<Vec3> places;
  for (std::size_t n = 0; n < s.size(); ++n)
    for (const SectionLine& line : s[n].lines) {
      of_line.push_back(static_cast<std::uint32_t>(n));
      closed.push_back(line.closed);
      for (const Uv& p : line.points) places.push_back(s[n].frame.place(p));
      offsets.push_back(places.size());
    }
  TRY(file.dataset("/sections/line_section", of_line));
  TRY(file.dataset("/sections/line_closed", closed));
  TRY(file.dataset("/sections/line_offsets", offsets));
  return file.dataset("/sections/line_points", places);
}

Result<void> write_refinement(Hdf5File& file, const Record& r) {
  if (r.told_poses.empty()) return {};
  const auto& pairs = r.pose_pairs;
  TRY(file.group("/refinement"));
  TRY(file.dataset("/refinement/told_pose", r.told_poses, {4, 4}));
  TRY(file.dataset("/refinement/a", column<std::uint32_t>(pairs, [](const PosePair& p) { return p.a; })));
  TRY(file.dataset("/refinement/b", column<std::uint32_t>(pairs, [](const PosePair& p) { return p.b; })));
  TRY(file.dataset("/refinement/matches", column<std::uint64_t>(pairs, [](const PosePair& p) { return p.matches; })));
  TRY(file.dataset("/refinement/before_mm", column<double>(pairs, [](const PosePair& p) { return p.before_mm; })));
  return file.dataset("/refinement/after_mm", column<double>(pairs, [](const PosePair& p) { return p.after_mm; }));
}

Result<void> write_stages(Hdf5File& file, const Record& r) {
  std::vector<std::pair<std::string, std::string>> stages = r.stage_versions;
  for (const Counter& counter : r.counters) {
    bool known = false;
    for (const auto& stage : stages) known = known || stage.first == counter.stage;
    if (!known) stages.emplace_back(counter.stage, "");
  }
  TRY(file.group("/stages"));
  for (std::size_t n = 0; n < stages.size(); ++n) {
    char number[24];
    std::snprintf(number, sizeof number, "%02zu", n + 1);
    const std::string path = "/stages/" + std::string(number) + "_" + stages[n].first;
    TRY(file.group(path));
    TRY(file.attribute(path, "version", stages[n].second));
    std::vector<Counter> counters;
    for (const Counter& counter : r.counters)
      if (counter.stage == stages[n].first) counters.push_back(counter);
    std::sort(counters.begin(), counters.end(), [](const Counter& a, const Counter& b) { return a.name < b.name; });
    for (const Counter& counter : counters) {
      const bool whole = counter.integer && std::abs(counter.value) < 9e18;  // NaN is not
      TRY(whole ? file.attribute(path, counter.name, static_cast<std::int64_t>(counter.value))
                : file.attribute(path, counter.name, counter.value));
    }
  }
  return {};
}

Result<void> write_notes(Hdf5File& file, const Record& r) {
  using Pair = std::pair<std::string, std::string>;
  static constexpr const char* kKinds[] = {"archive", "finding", "warning", "output"};
  std::vector<std::string> kinds(r.notes.size(), kKinds[1]);
  for (std::size_t n = 0; n < r.note_kinds.size(); ++n) kinds[n] = kKinds[static_cast<std::size_t>(r.note_kinds[n])];
  TRY(file.texts("/notes", r.notes));
  TRY(file.texts("/note_kinds", kinds));
  TRY(file.group("/outputs"));
  TRY(file.texts("/outputs/file", column<std::string>(r.outputs, [](const Pair& p) { return p.first; })));
  return file.texts("/outputs/sha256", column<std::string>(r.outputs, [](const Pair& p) { return p.second; }));
}

}  // namespace

Result<std::string> write_record(const Record& record, const std::string& path) {
  TRY(consistent(record, path));
  TRY_ASSIGN(Hdf5File file, Hdf5File::create(path));
  TRY(write_root(file, record));
  TRY(write_vtk(file, record));
  TRY(write_inputs(file, record));
  TRY(write_texts(file, record));
  TRY(write_reduced(file, record));
  TRY(write_mesh(file, record));
  TRY(write_patches(file, record));
  TRY(write_loops(file, record));
  TRY(write_fit(file, record));
  TRY(write_sections(file, record));
  TRY(write_refinement(file, record));
  TRY(write_stages(file, record));
  TRY(write_notes(file, record));
  const std::string identity = file.identity();
  TRY(file.attribute("/", "identity", identity, false));
  TRY(file.attribute("/", "content", file.content(), false));
  TRY(file.close());
  return identity;
}

Result<std::string> record_identity(const std::string& path) { return Hdf5File::read_root_text(path, "identity"); }

}  // namespace scanmill::provenance
