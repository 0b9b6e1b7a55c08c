// SPDX-License-Identifier: Apache-2.0
// A run in which everything happens, with names as only an archive can have them.
#pragma once
#include <string>

#include "runner/run_report.hpp"

namespace scanmill::runner {

/// Markup, quotes, line ends, tabs, a control byte, a byte that is no UTF-8, a direction mark, a terminal escape.
inline const std::string kEvil = "\"><b>&amp;|`*]]>\n\tx\r\x01\xff\xe2\x80\xae\x1b[31m\\end";

inline ScanEntry scan_entry(const std::string& name, ScanFate fate) {
  ScanEntry entry;
  entry.name = name;
  entry.fate = fate;
  entry.repeat = "scanmill run job.yaml --only " + name;
  if (fate != ScanFate::Done) return entry;
  entry.attempts = 1;
  entry.started = "2026-01-31T22:15:00Z";
  entry.ended = "2026-01-31T22:15:02Z";
  entry.seconds = 2;
  entry.cpu_seconds = 3.5;
  entry.peak_memory = 100 << 20;
  entry.counts = document::Node::map();
  entry.counts.set("points_read", 30000);
  entry.counts.set("triangles", 6240);
  entry.counts.set("boundary_loops", 1);
  entry.counts.set("max_error_mm", 0.5);
  entry.stage_seconds = {{"reduce", 0.25}, {"mesh", 1.5}};
  return entry;
}

inline ScanEntry failed_entry(const std::string& name, ScanFate fate, Error error) {
  ScanEntry entry = scan_entry(name, fate);
  entry.error = std::move(error);
  entry.failure = class_of(entry.error);
  entry.failed_stage = "reduce";
  entry.attempts = 2;
  return entry;
}

inline RunReport sample_run() {
  RunReport run;
  run.version = "0.1.0";
  run.libraries = document::Node::map();
  run.job_path = "jobs/night <&>.yaml";
  run.archive = "/srv/scans";
  run.out = "/srv/meshes";
  run.host = "mill";
  run.started = "2026-01-31T22:15:00Z";
  run.ended = "2026-01-31T23:15:00Z";
  run.seconds = 3600;
  run.threads = 2;
  run.exit_code = 3;
  ScanEntry done = scan_entry("done", ScanFate::Done);
  done.why = {"new"};
  done.notes = {"one view is missing", kEvil};
  run.scans.push_back(done);
  ScanEntry swapped = scan_entry("cleaned & rejected", ScanFate::Done);
  swapped.why = {"input v1.ply changed"};
  swapped.stage_seconds = {{"reduce", 1}, {"clean", 0.125}, {"mesh", 2}, {"verify", 4}};
  swapped.failed_gates = {"verify.max_error_mm: found 0.5 mm, allowed 0.1 mm"};
  run.scans.push_back(swapped);
  run.scans.push_back(scan_entry("same", ScanFate::Unchanged));
  run.scans.push_back(failed_entry(kEvil, ScanFate::Failed, fail(Code::BadInput, "found " + kEvil, kEvil)));
  run.scans.push_back(failed_entry("stale", ScanFate::Stale, fail(Code::Internal, "unexpected: surprise")));
  run.scans.push_back(failed_entry("hungry", ScanFate::Failed, fail(Code::NoSpace, "the cap was reached", "memory")));
  run.scans.push_back(failed_entry("full", ScanFate::Failed, fail(Code::NoSpace, "the disk is full", "/srv/meshes/x")));
  run.scans.push_back(failed_entry("cut", ScanFate::Interrupted, fail(Code::Cancelled, "stopped on request")));
  ScanEntry held = scan_entry("held", ScanFate::Quarantined);
  held.error = fail(Code::BadInput, "held/v2.ply: byte 81920: the file ends");
  run.scans.push_back(held);
  run.scans.push_back(scan_entry("later", ScanFate::Pending));
  run.scans.push_back(scan_entry("gone", ScanFate::Vanished));
  return run;
}

}  // namespace scanmill::runner
