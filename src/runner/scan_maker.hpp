// SPDX-License-Identifier: Apache-2.0
// One scan from its inputs to its committed folder: what a worker does, in this process or in one of its own.
#pragma once
#include <string>

#include "base/progress.hpp"
#include "runner/driver.hpp"
#include "runner/job_scans.hpp"
#include "runner/output_tree.hpp"
#include "runner/quarantine.hpp"
#include "runner/run_report.hpp"
#include "runner/scan_log.hpp"
#include "runner/scan_state.hpp"

namespace scanmill::runner {

/// What came of one attempt at a scan.
struct Attempt {
  ScanEntry entry;
  std::string fingerprint;                   // empty when the inputs could not be read
  bool output_is_bad = false;                // the output tree takes no more: nothing that follows could be kept
  std::string hashes;                        // of the scan's files, for Work::load_hashes
  std::optional<CutForecast> forecast = {};  // from the first part of a scan
};

document::Node to_document(const Attempt& attempt);
/// errors  Internal when the tree is no attempt
Result<Attempt> attempt_from(const document::Node& tree);

/// A scan whose fingerprint is known without reading a file.
struct Judgement {
  bool needs_work = true;
  ScanEntry entry;
};

class ScanMaker {
 public:
  struct Frame {
    const RunOptions& options;
    const OutputTree& tree;
    Work& work;
    const Quarantine& quarantine;
    const Stop& stop;
    std::string host;
    std::uint64_t memory = 0;  // of the whole run; 0: no cap
    std::uint64_t cap = 0;     // the same with what the driver takes
    std::uint64_t disk = 0;    // that a scan may use beside its results; 0: what is free
    double time_limit_s = 0;   // of a scan; 0: none
    std::uint64_t epoch = 0;   // of the journal; a later one ends the right to commit
    BrickKeys bricks = {};
    std::function<bool()>
        may_commit;  // in place of the epoch, where the one who ordered the scan may be another one now
  };
  explicit ScanMaker(Frame frame) : frame_(std::move(frame)) {}

  /// Reads no input, but for small ones of a scan that has a result: unchanged, quarantined, or in need of work (with
  /// the reasons as far as they are known).
  Judgement judge(const SelectedScan& scan, ScanEntry entry) const;
  /// Reads the inputs, and makes the scan when something changed. `memory` is the cap, for messages.
  Attempt make(const SelectedScan& scan, ScanEntry entry, int threads, std::uint64_t memory, Progress& progress) const;
  /// Makes one part of a scan that is cut. The entry is pending when it is there, failed when not, and unchanged when
  /// no part of the scan is needed: then nothing was made.
  Attempt make_part(const SelectedScan& scan, ScanEntry entry, const std::string& part, int threads,
                    std::uint64_t memory, Progress& progress) const;
  /// The parts of a scan as the job has it cut; no waves when it is made in one piece.
  CutParts parts_of(const SelectedScan& scan) const;

 private:
  bool settle(const SelectedScan& scan, const Fingerprint& fingerprint, const std::optional<ScanState>& state,
              ScanEntry& entry) const;
  void recall_hashes(const std::string& folder) const;
  bool needs_no_part(const SelectedScan& scan, const Fingerprint& fingerprint, const ScanEntry& entry) const;
  Result<std::unique_ptr<ScanLog>> begin_log(const SelectedScan& scan, const ScanEntry& entry, int threads,
                                             Progress& progress) const;
  Result<void> attempt(const SelectedScan& scan, const Fingerprint& fingerprint, ScanEntry& entry, int threads,
                       std::uint64_t memory, Progress& progress) const;
  Result<void> fill(const SelectedScan& scan, const Fingerprint& fingerprint, const std::string& folder,
                    ScanEntry& entry, int threads, std::uint64_t memory, Progress& progress) const;
  Result<void> still_ours() const;
  void fail_entry(const Error& error, bool has_result, ScanEntry& entry) const;

  Frame frame_;
};

/// The files of a scan's result, by name.
std::vector<Word> result_files(const OutputTree& tree, const std::string& name);

}  // namespace scanmill::runner
