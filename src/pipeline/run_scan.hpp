// SPDX-License-Identifier: Apache-2.0
// One scan from its files to mesh and record: load, call the stages, save.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/context.hpp"
#include "base/progress.hpp"
#include "base/result.hpp"
#include "pipeline/cut_scan.hpp"
#include "pipeline/discovery.hpp"
#include "pipeline/hash_cache.hpp"
#include "pipeline/part_forecast.hpp"
#include "pipeline/stage_clock.hpp"
#include "pipeline/what.hpp"

namespace scanmill::pipeline {

struct ScanResult {
  std::string name;
  std::uint64_t points_read = 0, points_used = 0, bins = 0, kept = 0;
  std::uint64_t points_meshed = 0;  // of the used ones: within one bin edge of the mesh
  std::uint64_t vertices = 0, triangles = 0, boundary_loops = 0, patches = 0, strays = 0;
  double max_error_mm = 0, rms_mm = 0;  // of all points that were used
  std::vector<std::string> notes;
  std::vector<std::string> failed_gates;  // one sentence each
  std::string record_identity;
  StageTimes stage_times;
};

/// What a report says about the run; nothing of it enters meshes or records.
struct RunFrame {
  std::string job, tool, date;
};

/// True when the reduction of such a scan can be done in parts (pipeline/cut_scan.hpp): the lattice is given by the job
/// alone, and no view is moved.
bool is_cuttable(const What& what);
/// One part of the scan's reduction, by the name that name_of(PartTask) gives; does nothing when it is there.
/// errors  BadParameter for a name that the cut does not have; those of run_scan up to its reduction
Result<void> make_part(const std::string& archive, const ScanSpec& scan, const What& what, const Cut& cut,
                       const std::string& part, const Context& context, Progress& progress);
/// What its parts hold, from one pass over its points.
Result<BinCounts> count_scan(const std::string& archive, const ScanSpec& scan, const What& what, const Cut& cut,
                             const Context& context, Progress& progress);

/// Names and versions of the stages in the order of the flow; a version rises when the stage's bytes change.
std::vector<std::pair<std::string, std::string>> stage_versions();

/// Canonical JSON of the keys of one scan.
struct KeyTexts {
  std::string mesh;  // all but the others
  std::string late;  // outputs and what the mesh is judged by
};
KeyTexts key_texts(const What& what, const std::string& scan);

/// Digests of a scan before work: content hashes of inputs (through the cache), keys, stage versions.
struct ScanDigests {
  std::string mesh;  // without the late keys
  std::string all;
};
/// errors  those of HashCache::entry_of; a file that the scan names and that is missing is no error, it counts as
/// missing
Result<ScanDigests> digests_of(const std::string& archive, const ScanSpec& scan, const KeyTexts& keys,
                               HashCache& cache);

/// Parts of a scan that is cut, and what they took.
struct MadeParts {
  Cut cut;
  StageTimes took;
};

/// Reads, meshes, judges, and writes the mesh files, record.h5, preview pictures and report.html complete and synced
/// into `folder` (exists, empty). With `in_tasks` the reduction is put together from its parts; those that are not
/// there are made first, one after the other. errors  BadInput naming file and place; NoSpace, IoFailed; Cancelled
Result<ScanResult> run_scan(const std::string& archive, const ScanSpec& scan, const What& what,
                            const std::string& folder, const RunFrame& frame, const Context& context,
                            Progress& progress, const std::optional<MadeParts>& in_tasks = std::nullopt);

/// A committed result of the same mesh (ScanDigests::mesh).
struct Previous {
  struct File {
    std::string name, sha256;
  };
  std::string folder;
  std::vector<File> files;
  const File* find(std::string_view name) const;
};

/// The same files, byte for byte, but for the run line of the report: mesh, patches and figures come from the record of
/// `previous`, pictures are taken over. Inputs are read only for sections and for outputs that hold bins; nothing is
/// meshed. `refusal` and no result when the earlier files are not what was written: then nothing is in `folder`.
/// errors  those of run_scan
Result<std::optional<ScanResult>> rewrite_scan(const std::string& archive, const ScanSpec& scan, const What& what,
                                               const Previous& previous, const std::string& folder,
                                               const RunFrame& frame, const Context& context, Progress& progress,
                                               std::string& refusal);

}  // namespace scanmill::pipeline
