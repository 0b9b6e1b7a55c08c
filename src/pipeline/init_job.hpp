// SPDX-License-Identifier: Apache-2.0
// A first job for an archive nobody has described yet.
#pragma once
#include <string>

#include "base/context.hpp"
#include "base/progress.hpp"
#include "base/result.hpp"

namespace scanmill::pipeline {

struct FirstJob {
  std::string text;  // a commented job
  std::size_t scans = 0, measured = 0;
};

/// Looks at the scans of an archive (the first, the last and up to 38 between them in full) and writes a job: units
/// with the reason, bin size from spacing and noise, overrides for scans that differ from the rest.
/// archive   folder; `name_in_job` is what the job is to call it
/// errors    BadInput when no scan is found or none can be read; Cancelled
Result<FirstJob> first_job(const std::string& archive, const std::string& name_in_job, const Context& context,
                           Progress& progress);

}  // namespace scanmill::pipeline
