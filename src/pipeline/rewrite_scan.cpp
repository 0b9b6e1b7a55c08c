// SPDX-License-Identifier: Apache-2.0
// A scan whose mesh stands: its files written again from the record, because outputs or gates changed.
#include <algorithm>

#include "base/digest.hpp"
#include "pipeline/clean_scan.hpp"
#include "pipeline/finish_scan.hpp"
#include "pipeline/run_scan.hpp"
#include "pipeline/scan_pictures.hpp"
#include "pipeline/scan_points.hpp"
#include "pipeline/scan_record.hpp"
#include "provenance/stored_record.hpp"
#include "store/files.hpp"

namespace scanmill::pipeline {
namespace {

using provenance::NoteKind;
using provenance::Record;

/// errors  BadInput when a file that is needed is not the one that was written
Result<provenance::StoredRecord> sound_record(const Previous& previous) {
  bool listed = false;
  for (const Previous::File& file : previous.files) {
    const bool is_record = file.name == kRecordFile;
    if (!is_record && !is_picture(file.name)) continue;
    listed = listed || is_record;
    const std::string path = previous.folder + "/" + file.name;
    TRY_ASSIGN(const auto source, store::open_file(path, path));
    TRY_ASSIGN(const std::string found, sha256_of(*source));
    if (found != file.sha256) return fail(Code::BadInput, "was changed after it was written", path);
  }
  if (!listed) return fail(Code::BadInput, "the earlier result has no record", previous.folder);
  return provenance::read_record(previous.folder + "/" + kRecordFile);
}

/// Notes that do not come from the outputs; those of the archive as it is now.
void renew_notes(const ScanSpec& scan, Record& record) {
  NoteList notes;
  notes.add(scan.notes, NoteKind::Archive);
  for (std::size_t n = 0; n < record.notes.size(); ++n)
    if (record.note_kinds[n] == NoteKind::Finding || record.note_kinds[n] == NoteKind::Warning)
      notes.add({std::move(record.notes[n])}, record.note_kinds[n]);
  record.notes = std::move(notes.texts);
  record.note_kinds = std::move(notes.kinds);
}

void renew_accuracy(const What& what, Record& record) {
  set_figure(record, "verify", "sensor_accuracy_mm", what.sensor.accuracy_mm);
  set_figure(record, "verify", "total_error_mm", figure(record, "verify", "fit_error_mm") + what.sensor.accuracy_mm);
}

/// As much of the surface as sections are cut from.
MeshedSurface surface_of(const Record& record) {
  MeshedSurface surface;
  surface.mesh = *record.mesh;
  surface.vertex_row = record.vertex_row;
  surface.stray_rows = record.stray_rows;
  surface.loops = record.loops;
  return surface;
}

bool needs_points(const What& what) {
  return !what.verify.sections.empty() || surfaces_output(what.outputs) ||
         std::any_of(what.outputs.begin(), what.outputs.end(), [](const Output& o) { return o.format == "vdb"; });
}

}  // namespace

const Previous::File* Previous::find(std::string_view name) const {
  const auto at = std::find_if(files.begin(), files.end(), [&](const File& file) { return file.name == name; });
  return at == files.end() ? nullptr : &*at;
}

Result<std::optional<ScanResult>> rewrite_scan(const std::string& archive, const ScanSpec& scan, const What& what,
                                               const Previous& previous, const std::string& folder,
                                               const RunFrame& frame, const Context& context, Progress& progress,
                                               std::string& refusal) {
  ScanResult result;
  result.name = scan.name;
  StageClock clock(result.stage_times);
  progress.stage("read record", 0, 0);
  if (const std::string missing = picture_missing(previous, what); !missing.empty()) {
    refusal = "it was made without " + missing;
    return std::optional<ScanResult>();
  }
  auto stored = sound_record(previous);
  if (!stored) {
    refusal = stored.error().text();
    return std::optional<ScanResult>();
  }
  FinishedScan finished;
  finished.record = std::move(stored->record);
  Record& record = finished.record;
  TRY(add_description(archive, scan, record));
  renew_notes(scan, record);
  renew_accuracy(what, record);
  TRY_ASSIGN(finished.quality, verify::quality_of(*record.mesh, context));
  clock.lap("read record");

  std::unique_ptr<ScanPoints> points;
  reduce::Reduction reduction;
  if (needs_points(what)) {
    TRY_ASSIGN(points, ScanPoints::open(archive, scan, what.units_mm, what.format));
    TRY_ASSIGN(const CleanedScan cleaned, clean_scan(*points, what, context, progress));
    progress.stage("bins", 0, 0);
    TRY_ASSIGN(reduction, reduce::reduce_cloud(*cleaned.points, what.lattice, what.reduce, context));
    finished.cloud = &reduction.cloud;
    clock.lap("bins");
    const auto& farthest = record.worst_interior.empty() ? record.worst : record.worst_interior;
    const std::optional<Vec3> worst = farthest.empty() ? std::nullopt : std::optional<Vec3>(farthest[0].place);
    progress.stage("sections", 0, 0);
    TRY_ASSIGN(finished.sections,
               measure_sections(surface_of(record), reduction.cloud, *cleaned.points, what, worst, context));
    if (!finished.sections.sections.empty()) clock.lap("sections");
    if (const Output* output = surfaces_output(what.outputs)) {
      const MeshedSurface surface = surface_of(record);
      const auto kept = without_strays(surface, reduction.cloud, *cleaned.points);
      const double bin_mm = reduction.report.bin_mm;
      TRY_ASSIGN(finished.surfaces, fit_scan_surfaces(surface.mesh, *kept, *output, bin_mm, context, progress));
      clock.lap("surfaces");
    }
    TRY(points->verify_unchanged());
  }
  const auto take_over = [&] { return copy_pictures(previous, what, folder); };
  TRY(finish_scan(finished, what, frame, folder, take_over, clock, progress, result));
  return std::optional<ScanResult>(std::move(result));
}

}  // namespace scanmill::pipeline
