// SPDX-License-Identifier: Apache-2.0
// A finished run in the words of other programs. Names and messages may hold any byte; every text here is well-formed
// whatever they hold.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "runner/night.hpp"
#include "runner/run_report.hpp"

namespace scanmill::runner {

/// JUnit XML: a scan of this run is a test case. Bad input and failed gates are failures, everything else that went
/// wrong is an error; quarantined scans and those not reached are skipped; vanished ones are no part of it.
std::string junit_xml(const RunReport& report);

/// Tab-separated, a line of names, then a row per scan: state, class, times, cost, counts, seconds of every stage.
/// Empty means unknown; tabs, line feeds and backslashes in names are written \t, \n, \\.
std::string trace_tsv(const RunReport& report);

/// Prometheus text format for the textfile collector of node_exporter. Every sample carries `job_file` and `out`, so
/// files of several jobs can lie in one folder. `before`: the file as the last run left it; the time of the last
/// success is taken from there when this run is none.
std::string prometheus_text(const RunReport& report, const std::string& before);

/// Markdown for $GITHUB_STEP_SUMMARY: verdict, totals, and tables of what failed and what became worse (50 rows each).
std::string step_summary(const RunReport& report, const std::vector<WorseScan>& worse);

/// Seconds since 1970 of "2026-01-31T08:15:00Z"; nothing for another text.
std::optional<std::int64_t> unix_seconds(const std::string& utc);

}  // namespace scanmill::runner
