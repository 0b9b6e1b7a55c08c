// SPDX-License-Identifier: Apache-2.0
// What a person should do about a scan; the same sentence on the console, in junit.xml, the step summary and the page.
#pragma once
#include <string>

#include "runner/run_report.hpp"

namespace scanmill::runner {

/// The class of what went wrong, from the error itself where the entry names none; None for a scan without error.
FailureClass failure_of(const ScanEntry& entry);

/// One or two sentences; empty for a scan that needs nobody.
std::string advice_for(const ScanEntry& entry);

/// What an exit code of a run says, for people: "2 scans failed", "all good", ...
std::string verdict_of(const RunReport& report);

}  // namespace scanmill::runner
