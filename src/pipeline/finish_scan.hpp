// SPDX-License-Identifier: Apache-2.0
// The last third of a scan: every file of its result, from what is known of it once it is meshed and judged. Whether
// that comes from the stages or from an older record makes no difference to a byte.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "base/context.hpp"
#include "pipeline/judge_scan.hpp"
#include "pipeline/mesh_files.hpp"
#include "pipeline/run_scan.hpp"
#include "pipeline/stage_clock.hpp"
#include "provenance/record.hpp"
#include "report/scan_report.hpp"
#include "verify/quality.hpp"

namespace scanmill::pipeline {

inline constexpr const char* kRecordFile = "record.h5";

struct FinishedScan {
  provenance::Record record;  // of record_of() or an older file's; keys, outputs and their notes are filled in here
  verify::Quality quality;    // of its mesh
  SectionResults sections;
  std::vector<WrittenFile> written;             // that stand in the folder already
  std::optional<ScanSurfaces> surfaces{};       // for outputs that hold them
  const reduce::ReducedCloud* cloud = nullptr;  // for outputs that hold bins
};

/// The pictures of the report, written into the folder.
using Pictures = FunctionRef<Result<std::vector<report::Picture>>()>;

/// Writes the outputs of the job, record.h5, pictures and report.html into `folder`.
/// result  gets counts, notes, failed gates and identity
/// errors  what the writers report; Internal when a file read back is not what was written
Result<void> finish_scan(FinishedScan& scan, const What& what, const RunFrame& frame, const std::string& folder,
                         Pictures pictures, StageClock& clock, Progress& progress, ScanResult& result);

}  // namespace scanmill::pipeline
