// SPDX-License-Identifier: Apache-2.0
// Proof of a record: what it says went in is what is there, what it says came out is what is there, and with a rerun,
// that the one gives the other.
#pragma once
#include <string>

#include "base/context.hpp"
#include "base/progress.hpp"
#include "pipeline/tools.hpp"

namespace scanmill::pipeline {

struct AuditChoice {
  std::string record;   // record.h5, or the folder of a scan
  std::string archive;  // empty: the one that run.json of the output tree names
  bool rerun = false;
};

/// Digests the record's own content, its inputs in the archive and its outputs beside it, and compares them with what
/// the record says. With `rerun` the scan is made again in a temporary folder from the record's keys and the archive
/// alone, and identity and outputs are compared.
///
/// returns  what was proven; everything that does not agree is a sentence in failed_gates, and so is a damaged record
/// errors   BadInput for what is no record at all; IoFailed, NoSpace of the machine, of a rerun too; Unsupported for a
///          whole record of another layout; BadUsage when no archive is known
Result<ToolReport> audit_record(const AuditChoice& choice, const Context& context, Progress& progress);

}  // namespace scanmill::pipeline
