// SPDX-License-Identifier: Apache-2.0
#include "provenance/stored_record.hpp"

#include <algorithm>
#include <array>

#include "provenance/hdf5_reader.hpp"

namespace scanmill::provenance {
namespace {

using Texts = std::vector<std::string>;

/// Values of one file; the first that is not as it was written fails the reading as a whole.
class Reading {
 public:
  explicit Reading(const std::string& path, const RecordReader& file) : path_(path), file_(file) {}

  template <class T>
  std::vector<T> numbers(const std::string& dataset, const std::string& attribute = {}) {
    auto values = file_.numbers<T>(dataset, attribute);
    if (!values) return take(std::move(values).error()), std::vector<T>{};
    return std::move(values).value();
  }
  Texts texts(const std::string& dataset) {
    auto list = file_.texts(dataset);
    if (!list) return take(std::move(list).error()), Texts{};
    return std::move(list).value();
  }
  std::string text(const std::string& object, const std::string& attribute) {
    auto value = file_.attribute(object, attribute);
    if (!value) return take(std::move(value).error()), std::string();
    return std::move(value).value();
  }
  /// Rows of a structure, filled column by column; all columns are as long as the first one given.
  template <class Row, class T, class Set>
  void column(std::vector<Row>& rows, const std::string& dataset, Set set) {
    fill(rows, dataset, numbers<T>(dataset), set);
  }
  template <class Row, class Set>
  void text_column(std::vector<Row>& rows, const std::string& dataset, Set set) {
    fill(rows, dataset, texts(dataset), set);
  }
  void require(bool holds, const std::string& what) {
    if (!holds) take(fail(Code::BadInput, what + " does not fit the rest; the record is damaged", path_));
  }
  const RecordReader& file() const { return file_; }
  bool good() const { return good_; }
  Error error() const { return first_; }

 private:
  template <class Row, class Value, class Set>
  void fill(std::vector<Row>& rows, const std::string& dataset, const std::vector<Value>& values, Set set) {
    if (rows.empty()) rows.resize(values.size());
    require(rows.size() == values.size(), dataset);
    for (std::size_t n = 0; n < std::min(rows.size(), values.size()); ++n) set(rows[n], values[n]);
  }
  void take(Error error) {
    if (good_) first_ = std::move(error);
    good_ = false;
  }

  std::string path_;
  const RecordReader& file_;
  bool good_ = true;
  Error first_;
};

Vec3 first_of(const std::vector<Vec3>& values) { return values.empty() ? Vec3{} : values[0]; }

/// Lists of different length out of one array of values and the places where they begin.
std::vector<std::vector<std::uint32_t>> lists_of(Reading& in, const std::string& offsets, const std::string& values) {
  const auto at = in.numbers<std::uint64_t>(offsets);
  const auto all = in.numbers<std::uint32_t>(values);
  std::vector<std::vector<std::uint32_t>> lists;
  const bool sound = !at.empty() && at.front() == 0 && at.back() == all.size() && std::is_sorted(at.begin(), at.end());
  in.require(sound, offsets);
  for (std::size_t n = 0; sound && n + 1 < at.size(); ++n)
    lists.emplace_back(all.begin() + static_cast<std::ptrdiff_t>(at[n]),
                       all.begin() + static_cast<std::ptrdiff_t>(at[n + 1]));
  return lists;
}

void read_mesh(Reading& in, Mesh& mesh, Record& r) {
  mesh.offset = first_of(in.numbers<Vec3>("/mesh", "offset_mm"));
  for (const auto& p : in.numbers<std::array<float, 3>>("/mesh/stl_positions"))
    mesh.positions.push_back({p[0], p[1], p[2]});
  mesh.triangles = in.numbers<Triangle>("/mesh/triangles");
  mesh.patch = in.numbers<std::uint32_t>("/mesh/patch");
  const auto header = in.numbers<std::uint8_t>("/mesh/stl_header");
  r.stl_header.assign(header.begin(), header.end());
  r.vertex_row = in.numbers<std::uint32_t>("/mesh/row");
  if (in.file().has("/mesh/growth_rank")) r.growth_rank = in.numbers<std::uint32_t>("/mesh/growth_rank");
  if (in.file().has("/VTKHDF/PointData/error_mm")) {
    r.vertex_error = in.numbers<float>("/VTKHDF/PointData/error_mm");
    r.vertex_error_rms = in.numbers<float>("/VTKHDF/PointData/error_rms_mm");
  }
  for (const Triangle& t : mesh.triangles)
    for (const std::uint32_t v : t)
      if (v >= mesh.positions.size()) return in.require(false, "/mesh/triangles");
}

void read_inputs(Reading& in, Record& r) {
  auto& rows = r.inputs;
  using Entry = InputEntry;
  in.text_column(rows, "/inputs/path", [](Entry& e, const std::string& v) { e.path = v; });
  in.text_column(rows, "/inputs/sha256", [](Entry& e, const std::string& v) { e.sha256 = v; });
  in.column<Entry, std::uint64_t>(rows, "/inputs/bytes", [](Entry& e, std::uint64_t v) { e.bytes = v; });
  in.text_column(rows, "/inputs/format", [](Entry& e, const std::string& v) { e.format = v; });
  in.text_column(rows, "/inputs/row_meaning", [](Entry& e, const std::string& v) { e.row_meaning = v; });
  in.column<Entry, std::array<double, 16>>(rows, "/inputs/pose",
                                           [](Entry& e, const std::array<double, 16>& v) { e.pose = v; });
  in.column<Entry, double>(rows, "/inputs/units_mm", [](Entry& e, double v) { e.units_mm = v; });
  in.column<Entry, std::uint64_t>(rows, "/inputs/points_read", [](Entry& e, std::uint64_t v) { e.points_read = v; });
  in.column<Entry, std::uint64_t>(rows, "/inputs/points_used", [](Entry& e, std::uint64_t v) { e.points_used = v; });
  in.column<Entry, std::uint64_t>(rows, "/inputs/not_finite", [](Entry& e, std::uint64_t v) { e.not_finite = v; });
  in.column<Entry, std::uint64_t>(rows, "/inputs/sensor_invalid",
                                  [](Entry& e, std::uint64_t v) { e.sensor_invalid = v; });
  in.column<Entry, std::uint8_t>(rows, "/inputs/missing", [](Entry& e, std::uint8_t v) { e.missing = v != 0; });
}

void read_reduced(Reading& in, Record& r) {
  const auto bin = in.numbers<double>("/reduced", "bin_mm");
  if (!bin.empty()) r.bin_mm = bin[0];
  r.lattice_origin = first_of(in.numbers<Vec3>("/reduced", "origin_mm"));
  r.points = in.numbers<Vec3>("/reduced/points");
  in.column<SourceKey, std::uint32_t>(r.source, "/reduced/source_view",
                                      [](SourceKey& k, std::uint32_t v) { k.view = ViewId{v}; });
  in.column<SourceKey, std::uint64_t>(r.source, "/reduced/source_row",
                                      [](SourceKey& k, std::uint64_t v) { k.row = v; });
  r.bins = in.numbers<std::array<std::int64_t, 3>>("/reduced/bin");
  r.drop = in.numbers<std::uint8_t>("/reduced/drop");
  if (auto names = in.file().attribute_texts("/reduced/drop", "drop_names")) r.drop_names = std::move(names).value();
}

void read_patches(Reading& in, Record& r) {
  using Entry = PatchEntry;
  in.column<Entry, Vec3>(r.patches, "/patches/seed", [](Entry& e, Vec3 v) { e.seed = v; });
  in.text_column(r.patches, "/patches/origin", [](Entry& e, const std::string& v) { e.origin = v; });
  in.column<Entry, std::uint64_t>(r.patches, "/patches/triangles", [](Entry& e, std::uint64_t v) { e.triangles = v; });
  in.column<Entry, double>(r.patches, "/patches/area_mm2", [](Entry& e, double v) { e.area_mm2 = v; });
  in.column<Entry, double>(r.patches, "/patches/border_mm", [](Entry& e, double v) { e.border_mm = v; });
  r.patch_borders = lists_of(in, "/patches/border_offsets", "/patches/border_vertices");
}

void read_loops(Reading& in, Record& r) {
  for (auto& vertices : lists_of(in, "/loops/offsets", "/loops/vertices"))
    r.loops.push_back({std::move(vertices), 0, {}});
  in.column<BorderLoop, double>(r.loops, "/loops/length_mm", [](BorderLoop& l, double v) { l.length_mm = v; });
  in.column<BorderLoop, Vec3>(r.loops, "/loops/centre", [](BorderLoop& l, Vec3 v) { l.centre = v; });
  using Entry = StrayEntry;
  in.column<Entry, std::uint64_t>(r.strays, "/strays/triangles", [](Entry& e, std::uint64_t v) { e.triangles = v; });
  in.column<Entry, std::uint64_t>(r.strays, "/strays/vertices", [](Entry& e, std::uint64_t v) { e.vertices = v; });
  in.column<Entry, Vec3>(r.strays, "/strays/centre", [](Entry& e, Vec3 v) { e.centre = v; });
  in.column<Entry, Vec3>(r.strays, "/strays/size", [](Entry& e, Vec3 v) { e.size = v; });
  r.stray_rows = in.numbers<std::uint32_t>("/strays/rows");
  for (const std::uint32_t row : r.stray_rows)
    if (row >= r.points.size()) return in.require(false, "/strays/rows");
}

void read_fit(Reading& in, Record& r) {
  if (!in.file().has("/fit")) return;
  r.histogram = in.numbers<std::uint64_t>("/fit/histogram");
  for (const auto& row : in.numbers<std::array<double, 8>>("/fit/patches"))
    r.patch_fits.push_back({static_cast<std::uint32_t>(row[0]), static_cast<std::uint64_t>(row[1]), row[2], row[3],
                            row[4], row[5], row[6], row[7]});
  std::vector<WorstEntry> worst;
  in.column<WorstEntry, std::array<double, 4>>(worst, "/fit/worst", [](WorstEntry& e, const std::array<double, 4>& v) {
    e.place = {v[0], v[1], v[2]};
    e.signed_mm = v[3];
  });
  in.column<WorstEntry, std::array<std::uint64_t, 4>>(worst, "/fit/worst_source",
                                                      [](WorstEntry& e, const std::array<std::uint64_t, 4>& v) {
                                                        e.source = {ViewId{static_cast<std::uint32_t>(v[0])}, v[1]};
                                                        e.patch = static_cast<std::uint32_t>(v[2]);
                                                        e.open_border = v[3] != 0;
                                                      });
  const auto first = in.numbers<std::int64_t>("/fit/worst", "of_all_points");
  const bool sound = first.size() == 1 && first[0] >= 0 && static_cast<std::uint64_t>(first[0]) <= worst.size();
  if (!sound) return in.require(false, "/fit/worst");
  const auto middle = worst.begin() + first[0];
  r.worst.assign(worst.begin(), middle);
  r.worst_interior.assign(middle, worst.end());
}

/// Groups "01_read", "02_reduce", ...
Result<void> read_stages(const RecordReader& file, Record& r) {
  TRY_ASSIGN(const Texts groups, file.children("/stages"));
  for (const std::string& group : groups) {
    const std::string path = "/stages/" + group, stage = group.substr(std::min(group.find('_') + 1, group.size()));
    TRY_ASSIGN(std::string version, file.attribute(path, "version"));
    r.stage_versions.emplace_back(stage, std::move(version));
    for (const std::string& name : file.attributes(path)) {
      if (name == "version") continue;
      Counter counter{stage, name, 0, false};
      TRY_ASSIGN(counter.value, file.number(path, name, counter.integer));
      r.counters.push_back(std::move(counter));
    }
  }
  return {};
}

void read_notes(Reading& in, Record& r) {
  static constexpr std::string_view kKinds[] = {"archive", "finding", "warning", "output"};
  r.notes = in.texts("/notes");
  for (const std::string& kind : in.texts("/note_kinds")) {
    const auto at = std::find(std::begin(kKinds), std::end(kKinds), kind);
    in.require(at != std::end(kKinds), "/note_kinds");
    r.note_kinds.push_back(static_cast<NoteKind>(std::min<std::ptrdiff_t>(at - std::begin(kKinds), 3)));
  }
  in.require(r.notes.size() == r.note_kinds.size(), "/note_kinds");
  const Texts files = in.texts("/outputs/file"), digests = in.texts("/outputs/sha256");
  in.require(files.size() == digests.size(), "/outputs/sha256");
  for (std::size_t n = 0; n < std::min(files.size(), digests.size()); ++n) r.outputs.emplace_back(files[n], digests[n]);
}

}  // namespace

Result<StoredRecord> read_record(const std::string& path) {
  TRY_ASSIGN(const RecordReader file, RecordReader::open(path));
  StoredRecord stored;
  stored.mesh = std::make_unique<Mesh>();
  Record& r = stored.record;
  r.mesh = stored.mesh.get();
  Reading in(path, file);
  r.scan = in.text("/", "title");
  stored.identity = in.text("/", "identity");
  const Texts what = in.texts("/parameters/what_json");
  if (!what.empty()) r.what_json = what[0];
  r.description_path = in.text("/description", "path");
  r.description_sha256 = in.text("/description", "sha256");
  read_mesh(in, *stored.mesh, r);
  read_inputs(in, r);
  read_reduced(in, r);
  read_patches(in, r);
  read_loops(in, r);
  read_fit(in, r);
  read_notes(in, r);
  if (!in.good()) return in.error();
  TRY(read_stages(file, r));
  return stored;
}

}  // namespace scanmill::provenance
