// SPDX-License-Identifier: Apache-2.0
// run.json: everything about a run that is no part of a result (times, host, versions, job as written, states,
// failures).
#pragma once
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "base/bytes.hpp"
#include "base/result.hpp"
#include "document/document.hpp"
#include "runner/word.hpp"

namespace scanmill::runner {

/// What went wrong, by what should be done about it.
enum class FailureClass {
  None,
  BadInput,   // never retried
  Resource,   // memory; retried with more, up to the cap
  Transient,  // a fault that may pass; retried after a while
  Cancelled,
  Internal,  // crash, hang, error in the program
};
const char* name_of(FailureClass failure);
FailureClass failure_named(const std::string& name);
FailureClass class_of(const Error& error);

enum class ScanFate {
  Pending,    // not reached
  Unchanged,  // an earlier result stands
  Done,
  Failed,       // no result
  Stale,        // failed; the last good result stands, made from other inputs or keys
  Quarantined,  // failed before on the same work; not tried again
  Interrupted,
  Vanished,  // its source is gone; its result is kept
};
const char* name_of(ScanFate fate);

struct ScanEntry {
  std::string name;
  ScanFate fate = ScanFate::Pending;
  std::vector<std::string> why;  // reasons to run; empty when unchanged
  std::vector<std::string> notes;
  std::vector<std::string> failed_gates;  // of the result that stands
  Error error;                            // of Failed, Stale, Quarantined, Interrupted
  FailureClass failure = FailureClass::None;
  std::string failed_stage;    // the stage that was running; empty when not known
  std::string repeat;          // the command that repeats this scan alone; of those with an error
  int attempts = 0;            // in this run
  std::string started, ended;  // UTC; empty when it was not worked on
  double seconds = 0, cpu_seconds = 0;
  std::vector<std::pair<std::string, double>> stage_seconds, stage_cpu_seconds;
  std::uint64_t peak_memory = 0;  // of the process that made it, when the scan ended
  Counts counts;
  std::string record_identity;
  std::vector<Word> files;  // names in the scan's folder
};

struct RunReport {
  std::string version;
  document::Node libraries;
  std::string job_path, job_absolute, job_text, archive, archive_absolute, out;
  std::vector<std::string> sets, only;
  std::string host, started, ended;
  int pid = 0, threads = 0;
  std::uint64_t memory_cap = 0;
  double seconds = 0;
  double waited = 0;   // seconds of these with nothing at work: files were to settle, or a fault to pass
  int exit_code = -1;  // -1: still running
  bool dry_run = false;
  bool written = false;            // run.json is there
  bool has_page = false;           // report.html is there, of this run
  std::vector<std::string> notes;  // of the archive as a whole
  std::uint64_t put_off = 0;       // scans that were not started because of resources.until
  std::vector<ScanEntry> scans;

  std::uint64_t count(ScanFate fate) const;
  std::uint64_t rejected() const;  // results that failed a gate
};

/// The scan's files, relative to the output tree.
std::vector<std::string> paths_of(const ScanEntry& entry);

document::Node to_document(const ScanEntry& entry);
/// errors  Internal when the tree is no scan of a run.json
Result<ScanEntry> entry_from(const document::Node& tree);
document::Node to_document(const RunReport& report);
/// The same without `scans`, which stands last.
document::Node head_of(const RunReport& report);
/// run.json, with one scan at a time in memory; the bytes of to_json(to_document(report), 1) and a line feed.
/// errors  those of the sink, which is not committed
Result<void> write_run(const RunReport& report, ByteSink& sink);
/// "2 scans: 0 unchanged, 2 done, 0 failed, 0 quarantined | gates: 0 | 00:00:07 h | OUT/report.html | exit 0"; ", 2 not
/// made" and ", 1 vanished" follow where there are any.
std::string last_line(const RunReport& report);
/// The same as an event of type "summary".
document::Node last_event(const RunReport& report);

}  // namespace scanmill::runner
