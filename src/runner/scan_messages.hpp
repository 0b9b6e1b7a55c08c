// SPDX-License-Identifier: Apache-2.0
// What the console says about a scan, and how to run it again.
#pragma once
#include <string>
#include <vector>

#include "runner/console.hpp"
#include "runner/driver.hpp"
#include "runner/output_tree.hpp"
#include "runner/run_report.hpp"

namespace scanmill::runner {

std::string joined_lines(const std::vector<std::string>& lines, const char* between);
/// "1.23 s"
std::string seconds_text(double seconds);
/// The command that repeats one scan of a run, for a shell.
std::string repeat_command(const RunOptions& options, const std::string& scan);
/// The part of the scan ("map 3") that a failure found missing, or damaged and removed, or nothing. `maker`: the part
/// that failed, which may not have found room for its own file; empty: the scan itself.
std::string missing_part(const ScanEntry& entry, const OutputTree& tree, const std::string& maker);
/// One line or event for a scan that was reached. `out` is the output tree; `quiet_unchanged`: an unchanged scan gets
/// no line, only the event.
void show_scan(const ScanEntry& entry, const std::string& out, bool explain, bool dry_run, bool quiet_unchanged,
               Console& console);

}  // namespace scanmill::runner
