// SPDX-License-Identifier: Apache-2.0
#include "pipeline/run_scan.hpp"

#include <chrono>
#include <cmath>
#include <mutex>

#include "base/digest.hpp"
#include "base/text.hpp"
#include "pipeline/bin_files.hpp"
#include "pipeline/clean_scan.hpp"
#include "pipeline/density.hpp"
#include "pipeline/judge_scan.hpp"
#include "pipeline/mesh_files.hpp"
#include "pipeline/refine_scan.hpp"
#include "pipeline/scan_page.hpp"
#include "pipeline/scan_pictures.hpp"
#include "pipeline/scan_points.hpp"
#include "pipeline/scan_record.hpp"
#include "pipeline/section_files.hpp"
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

/// Times the stages that a function tells of under the names it tells them by.
class TimedStages final : public Progress {
 public:
  TimedStages(StageClock& clock, Progress& onward) : clock_(clock), onward_(onward) {}
  void stage(std::string_view name, std::uint64_t done, std::uint64_t total) override {
    {
      const std::lock_guard guard(mutex_);
      if (name != name_) {
        if (!name_.empty()) clock_.lap(name_.c_str());
        name_ = name;
      }
    }
    onward_.stage(name, done, total);
  }
  void end() { clock_.lap(name_.c_str()); }

 private:
  StageClock& clock_;
  Progress& onward_;
  std::mutex mutex_;
  std::string name_;
};

/// Stages do not know files: an error without a place gets the file that stands for the scan.
Error name_file(Error error, const ScanSpec& scan) {
  if (!error.where.empty()) return error;
  return std::move(error).at(scan.description.empty() ? scan.views.front().path : scan.description);
}

/// To a hundredth of a millimetre.
std::string place_text(Vec3 p) {
  auto text = [](double v) { return number_text(std::floor(v * 100 + 0.5) / 100); };
  return text(p.x) + " " + text(p.y) + " " + text(p.z);
}

void add_notes(const MeshedSurface& surface, const reduce::Report& report, const Mesh& mesh,
               std::vector<std::string>& notes) {
  if (report.not_finite > 0)
    notes.push_back(counted(report.not_finite, "point") + (report.not_finite == 1 ? " is" : " are") +
                    " NaN or infinite and dropped");
  if (!surface.strays.empty())
    notes.push_back(counted(surface.strays.size(), "stray component") +
                    (surface.strays.size() == 1 ? " was" : " were") + " dropped (" +
                    counted(surface.kept_in_strays, "point") + "), listed in the record under /strays");
  if (surface.sides_by_volume > 0 && !surface.loops.empty())
    notes.push_back("no view tells which side of " + counted(surface.sides_by_volume, "component") + " is outside; " +
                    (surface.sides_by_volume == 1 ? "it was" : "each was") +
                    " turned so that it bulges outward, which for open surfaces is a guess");
  if (!(mesh.offset == Vec3{}))
    notes.push_back(
        "float32 would cost more than a thousandth of the bin edge this far from the origin: the STL is "
        "translated by " +
        number_text(0 - mesh.offset.x) + " " + number_text(0 - mesh.offset.y) + " " + number_text(0 - mesh.offset.z) +
        " mm");
}

std::vector<std::string> coverage_warnings(const ScanResults& all) {
  std::vector<std::string> list;
  const reduce::ReducedCloud& cloud = all.reduction.cloud;
  if (std::string note = fine_bins_note(cloud); !note.empty()) list.push_back(std::move(note));
  if (std::string note = coverage_note(all.fit.points_near, all.reduction.report.points_used,
                                       unmeshed_points(all.surface, cloud), cloud, all.what.seeds.cover);
      !note.empty())
    list.push_back(std::move(note));
  return list;
}

/// Where the mesh stands for nearly all points, but not for some.
void add_unmeshed_note(const ScanResults& all, std::vector<std::string>& notes) {
  const Unmeshed off = unmeshed_points(all.surface, all.reduction.cloud);
  if (off.points == 0) return;
  const std::string points = counted(off.points, "input point") + " in " + counted(off.bins, "bin");
  const std::string place = std::string(off.points == 1 ? "is" : "are") + " on no triangle, first near " +
                            place_text(off.first) + "; they count in the fit error";
  if (all.what.seeds.cover)
    notes.push_back(points + " of bare surroundings " + place + ": remove them (clean) or choose larger bins");
  else
    notes.push_back(points + ", where no given seed reaches (seeds.cover: false) or in bare surroundings, " + place);
}

}  // namespace

std::vector<std::pair<std::string, std::string>> stage_versions() {
  return {{"read", "3"}, {"clean", "1"},    {"reduce", "2"}, {"stars", "2"},  {"front", "1"},  {"merge", "1"},
          {"grow", "1"}, {"optimise", "1"}, {"verify", "2"}, {"export", "2"}, {"record", "6"}, {"report", "3"}};
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
  if (what.refine.poses) line("refine 1");
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
                            const std::string& folder, const RunFrame& frame, const Context& context,
                            Progress& progress) {
  ScanResult result;
  result.name = scan.name;
  result.notes = scan.notes;
  StageClock clock(result.stage_seconds);

  TRY_ASSIGN(const auto points, ScanPoints::open(archive, scan, what.units_mm, what.format));
  for (const OpenView& view : points->views())
    for (const std::string& note : view.header.notes) result.notes.push_back(view.path + ": " + note);
  clock.lap("open");

  auto moved = refine_scan(*points, scan, what, context, progress);
  if (!moved.ok()) return name_file(std::move(moved).error(), scan);
  const RefinedScan refined = std::move(moved).value();
  add_refine_notes(refined, *points, result.notes);
  if (refined.report) clock.lap("refine");

  auto clean = clean_scan(*points, what, context, progress);
  if (!clean.ok()) return name_file(std::move(clean).error(), scan);
  const CleanedScan cleaned = std::move(clean).value();
  if (cleaned.cleaned) clock.lap("clean");

  const WatchedPoints watched(*cleaned.points, "reduce", progress);
  auto reduced = reduce::reduce_cloud(watched, what.lattice, what.reduce, context);
  if (!reduced.ok()) return name_file(explained(std::move(reduced).error(), cleaned), scan);
  if (auto seen = points->check_bands(result.notes); !seen.ok()) return name_file(std::move(seen).error(), scan);
  reduce::Reduction reduction = std::move(reduced).value();
  const reduce::Report& report = reduction.report;
  if (std::string problem = implausible_size(report.bounds, points->units_mm(), report.bin_mm); !problem.empty())
    return name_file(fail(Code::BadInput, std::move(problem)), scan);
  clock.lap("reduce");

  TimedStages timed(clock, progress);
  auto meshed = mesh_surface(reduction.cloud, report.bounds, what, context, timed);
  if (!meshed.ok()) return name_file(std::move(meshed).error(), scan);
  ScanResults all{archive, scan, what, *points, cleaned, std::move(reduction), std::move(meshed).value(), {}, {}, {},
                  0,       {},   {},   {},      {}};
  all.refined = &refined;
  MeshedSurface& surface = all.surface;
  timed.end();

  TRY_ASSIGN(all.swaps, optimise_surface(surface, what, all.reduction.report.bin_mm, context, progress));
  clock.lap("optimise");
  TRY_ASSIGN(all.quality, verify::quality_of(surface.mesh, context));
  TRY_ASSIGN(Fit fit, measure_fit(surface, all.reduction.cloud, *cleaned.points, what, context, progress));
  all.fit = std::move(fit.report);
  all.points_in_strays = fit.points_in_strays;
  all.sections = std::move(fit.sections);
  result.notes.insert(result.notes.end(), fit.notes.begin(), fit.notes.end());
  result.failed_gates = failed_gates(all.fit);
  clock.lap("verify");

  progress.stage("export", 0, 0);
  for (const Output& output : what.outputs) {
    if (output.format == "vdb") {
      TRY_ASSIGN(WrittenFile bins, write_bins_file(all.reduction.cloud, folder + "/" + file_name_of(output)));
      all.outputs.push_back(std::move(bins));
      continue;
    }
    TRY_ASSIGN(WrittenFile file, write_mesh_file(surface.mesh, output, vertex_errors(all.fit),
                                                 folder + "/" + file_name_of(output), all.reduction.report.bin_mm));
    result.notes.insert(result.notes.end(), file.notes.begin(), file.notes.end());
    all.outputs.push_back(std::move(file));
  }
  TRY_ASSIGN(std::vector<WrittenFile> sheets, write_section_files(all.sections, folder));
  for (WrittenFile& sheet : sheets) all.outputs.push_back(std::move(sheet));
  if (refined.report) {
    TRY_ASSIGN(WrittenFile motions, write_refinement(refined, *points, folder));
    all.outputs.push_back(std::move(motions));
  }
  clock.lap("export");

  add_clean_notes(cleaned, result.notes);
  add_notes(surface, all.reduction.report, surface.mesh, result.notes);
  if (all.points_in_strays > 0)
    result.notes.push_back(counted(all.points_in_strays, "input point") +
                           (all.points_in_strays == 1 ? " lies" : " lie") + " in dropped components and " +
                           (all.points_in_strays == 1 ? "is" : "are") + " not part of the fit error");
  all.warnings = coverage_warnings(all);
  result.notes.insert(result.notes.end(), all.warnings.begin(), all.warnings.end());
  if (all.warnings.empty()) add_unmeshed_note(all, result.notes);
  all.notes = result.notes;
  TRY_ASSIGN(all.digests, points->digests(context));
  TRY(points->verify_unchanged());
  TRY_ASSIGN(const provenance::Record record, record_of(all));
  TRY_ASSIGN(result.record_identity, provenance::write_record(record, folder + "/record.h5"));
  clock.lap("record");

  TRY_ASSIGN(auto pictures, write_pictures(all, folder, context, progress));
  clock.lap("pictures");
  TRY_ASSIGN(auto sections, draw_sections(all, folder));
  PageFrame page{frame.job, frame.tool, result.record_identity, frame.date, result.stage_seconds};
  TRY_ASSIGN(auto sink, store::create_file(folder + "/report.html"));
  TRY(report::write_scan_report(page_of(all, std::move(pictures), std::move(sections), page), *sink));
  TRY(sink->commit());
  clock.lap("report");

  const reduce::Report& counts = all.reduction.report;
  result.points_read = counts.points_read;
  result.points_used = counts.points_used;
  result.points_meshed = all.fit.points_near;
  result.bins = counts.bins;
  result.kept = counts.kept;
  result.max_error_mm = all.fit.all.max_mm;
  result.rms_mm = all.fit.all.rms_mm;
  result.vertices = surface.mesh.positions.size();
  result.triangles = surface.mesh.triangles.size();
  result.boundary_loops = surface.loops.size();
  result.patches = surface.patches.patches.size();
  result.strays = surface.strays.size();
  return result;
}

}  // namespace scanmill::pipeline
