// SPDX-License-Identifier: Apache-2.0
#include "pipeline/run_scan.hpp"

#include <chrono>

#include "base/digest.hpp"
#include "base/text.hpp"
#include "export/writers.hpp"
#include "pipeline/scan_points.hpp"
#include "pipeline/scan_record.hpp"
#include "pipeline/surface.hpp"
#include "pipeline/watched_points.hpp"
#include "store/files.hpp"

namespace scanmill::pipeline {
namespace {

/// Wall seconds of each stage, for run.json only.
class StageClock {
 public:
  explicit StageClock(std::vector<std::pair<std::string, double>>& out) : out_(out), last_(Clock::now()) {}
  void lap(const char* stage) {
    const auto now = Clock::now();
    out_.push_back({stage, std::chrono::duration<double>(now - last_).count()});
    last_ = now;
  }

 private:
  using Clock = std::chrono::steady_clock;
  std::vector<std::pair<std::string, double>>& out_;
  Clock::time_point last_;
};

/// Writes the STL, reads it back and compares; its SHA-256.
Result<std::string> write_and_check_stl(const Mesh& mesh, const std::string& path) {
  TRY_ASSIGN(auto sink, store::create_file(path));
  TRY(exporting::write_stl(mesh, *sink));
  TRY(sink->commit());
  TRY_ASSIGN(const auto source, store::open_file(path, path));
  TRY(exporting::compare_stl(mesh, *source));
  return sha256_of(*source);
}

/// Stages do not know files: an error without a place gets the file that stands for the scan.
Error name_file(Error error, const ScanSpec& scan) {
  if (!error.where.empty()) return error;
  return std::move(error).at(scan.description.empty() ? scan.views.front().path : scan.description);
}

void add_notes(const MeshedSurface& surface, const reduce::Report& report, const Mesh& mesh,
               std::vector<std::string>& notes) {
  if (report.not_finite > 0)
    notes.push_back(grouped(report.not_finite) + " points are NaN or infinite and were dropped");
  if (!surface.strays.empty())
    notes.push_back(grouped(surface.strays.size()) + " stray components were dropped (" +
                    grouped(surface.kept_in_strays) + " points); they are listed in the record under /strays");
  if (!(mesh.offset == Vec3{}))
    notes.push_back(
        "float32 would cost more than a thousandth of the bin edge this far from the origin: the STL is "
        "translated by " +
        number_text(0 - mesh.offset.x) + " " + number_text(0 - mesh.offset.y) + " " + number_text(0 - mesh.offset.z) +
        " mm");
}

}  // namespace

std::vector<std::pair<std::string, std::string>> stage_versions() {
  return {{"read", "1"},  {"reduce", "1"}, {"stars", "1"},  {"front", "1"},
          {"merge", "1"}, {"grow", "1"},   {"export", "1"}, {"record", "1"}};
}

Result<std::string> fingerprint_of(const std::string& archive, const ScanSpec& scan, const What& what,
                                   HashCache& cache) {
  Sha256 hash;
  auto line = [&](const std::string& text) {
    hash.add(std::string_view(text));
    hash.add(std::string_view("\n"));
  };
  for (const auto& [stage, version] : stage_versions()) line(stage + " " + version);
  line(document::to_canonical_json(to_document(what_for(what, scan.name))));
  line(scan.name);
  if (!scan.description.empty()) {
    TRY_ASSIGN(const HashCache::Entry entry, cache.entry_of(archive + "/" + scan.description, scan.description));
    line(scan.description + " " + entry.sha256);
  }
  for (const ViewSpec& view : scan.views) {
    if (view.missing) {
      line(view.path + " missing");
      continue;
    }
    TRY_ASSIGN(const HashCache::Entry entry, cache.entry_of(archive + "/" + view.path, view.path));
    line(view.path + " " + entry.sha256);
  }
  return hash.hex();
}

Result<ScanResult> run_scan(const std::string& archive, const ScanSpec& scan, const What& what,
                            const std::string& folder, const Context& context, Progress& progress) {
  ScanResult result;
  result.name = scan.name;
  result.notes = scan.notes;
  StageClock clock(result.stage_seconds);

  TRY_ASSIGN(const auto points, ScanPoints::open(archive, scan, what.units_mm, what.format));
  for (const OpenView& view : points->views())
    for (const std::string& note : view.header.notes) result.notes.push_back(view.path + ": " + note);
  clock.lap("open");

  const WatchedPoints watched(*points, "reduce", progress);
  auto reduced = reduce::reduce_cloud(watched, what.lattice, what.reduce, context);
  if (!reduced.ok()) return name_file(std::move(reduced).error(), scan);
  reduce::Reduction reduction = std::move(reduced).value();
  const reduce::Report& report = reduction.report;
  if (std::string problem = implausible_size(report.bounds, points->units_mm(), report.bin_mm); !problem.empty())
    return name_file(fail(Code::BadInput, std::move(problem)), scan);
  clock.lap("reduce");

  auto meshed = mesh_surface(reduction.cloud, report.bounds, what, context, progress);
  if (!meshed.ok()) return name_file(std::move(meshed).error(), scan);
  const MeshedSurface surface = std::move(meshed).value();
  clock.lap("mesh");

  progress.stage("write", 0, 0);
  TRY_ASSIGN(const std::string stl_digest, write_and_check_stl(surface.mesh, folder + "/mesh.stl"));
  clock.lap("export");

  add_notes(surface, report, surface.mesh, result.notes);
  TRY_ASSIGN(const std::vector<std::string> digests, points->digests(context));
  TRY(points->verify_unchanged());
  TRY_ASSIGN(const provenance::Record record,
             record_of(archive, scan, what, *points, digests, reduction, surface, result.notes, stl_digest));
  TRY_ASSIGN(result.record_identity, provenance::write_record(record, folder + "/record.h5"));
  clock.lap("record");

  result.points_read = report.points_read;
  result.points_used = report.points_used;
  result.bins = report.bins;
  result.kept = report.kept;
  result.vertices = surface.mesh.positions.size();
  result.triangles = surface.mesh.triangles.size();
  result.boundary_loops = surface.loops.size();
  result.patches = surface.patches.patches.size();
  result.strays = surface.strays.size();
  return result;
}

}  // namespace scanmill::pipeline
