// SPDX-License-Identifier: Apache-2.0
#include "pipeline/finish_scan.hpp"

#include <algorithm>

#include "pipeline/bin_files.hpp"
#include "pipeline/scan_page.hpp"
#include "pipeline/scan_record.hpp"
#include "pipeline/section_files.hpp"
#include "store/files.hpp"

namespace scanmill::pipeline {
namespace {

using provenance::NoteKind;
using provenance::Record;

Result<std::vector<WrittenFile>> write_outputs(const FinishedScan& scan, const What& what, const std::string& folder) {
  const Record& record = scan.record;
  const VertexErrors errors{record.vertex_error, record.vertex_error_rms};
  std::vector<WrittenFile> files;
  for (const Output& output : what.outputs) {
    const std::string path = folder + "/" + file_name_of(output);
    if (output.format == "vdb") {
      if (!scan.cloud) return fail(Code::Internal, "there are no bins to be written", path);
      TRY_ASSIGN(WrittenFile bins, write_bins_file(*scan.cloud, path));
      files.push_back(std::move(bins));
      continue;
    }
    TRY_ASSIGN(WrittenFile file, write_mesh_file(*record.mesh, output, errors, path, record.bin_mm,
                                                 scan.surfaces ? &*scan.surfaces : nullptr));
    files.push_back(std::move(file));
  }
  TRY_ASSIGN(std::vector<WrittenFile> sheets, write_section_files(scan.sections.sections, what.outputs, folder));
  for (WrittenFile& sheet : sheets) files.push_back(std::move(sheet));
  files.insert(files.end(), scan.written.begin(), scan.written.end());
  return files;
}

void add_output_notes(const FinishedScan& scan, const std::vector<WrittenFile>& files, Record& record) {
  auto add = [&](const std::vector<std::string>& notes) {
    record.notes.insert(record.notes.end(), notes.begin(), notes.end());
    record.note_kinds.insert(record.note_kinds.end(), notes.size(), NoteKind::Output);
  };
  add(scan.sections.notes);
  for (const WrittenFile& file : files) add(file.notes);
}

void state_result(const Record& record, const What& what, ScanResult& result) {
  result.points_read = count(record, "read", "points_read");
  result.points_used = count(record, "reduce", "points_used");
  result.points_meshed = count(record, "verify", "points_near");
  result.bins = count(record, "reduce", "bins");
  result.kept = count(record, "reduce", "kept");
  result.max_error_mm = figure(record, "verify", "max_mm");
  result.rms_mm = figure(record, "verify", "rms_mm");
  result.vertices = record.mesh->positions.size();
  result.triangles = record.mesh->triangles.size();
  result.boundary_loops = record.loops.size();
  result.patches = record.patches.size();
  result.strays = record.strays.size();
  result.notes = record.notes;
  result.failed_gates = failed_gates(verify::gates_of(what.verify, result.max_error_mm, result.rms_mm));
}

}  // namespace

Result<void> finish_scan(FinishedScan& scan, const What& what, const RunFrame& frame, const std::string& folder,
                         Pictures pictures, StageClock& clock, Progress& progress, ScanResult& result) {
  Record& record = scan.record;
  progress.stage("export", 0, 0);
  TRY_ASSIGN(const std::vector<WrittenFile> files, write_outputs(scan, what, folder));
  clock.lap("export");
  add_output_notes(scan, files, record);
  record.what_json = document::to_canonical_json(to_document(what_for(what, record.scan)));
  record.sections = scan.sections.sections;
  record.outputs.clear();
  for (const WrittenFile& file : files) record.outputs.emplace_back(file.name, file.sha256);
  progress.stage("record", 0, 0);
  TRY_ASSIGN(result.record_identity, provenance::write_record(record, folder + "/" + kRecordFile));
  clock.lap("record");
  TRY_ASSIGN(auto drawn, pictures());
  clock.lap("pictures");
  progress.stage("report", 0, 0);
  TRY_ASSIGN(auto sections, draw_sections(scan.sections.sections, folder));
  state_result(record, what, result);
  const PageFrame page{frame.job, frame.tool, result.record_identity, frame.date, result.stage_times.wall_s};
  TRY_ASSIGN(auto sink, store::create_file(folder + "/report.html"));
  TRY(report::write_scan_report(page_of(scan, what, files, std::move(drawn), std::move(sections), page), *sink));
  TRY(sink->commit());
  clock.lap("report");
  return {};
}

}  // namespace scanmill::pipeline
