// SPDX-License-Identifier: Apache-2.0
// The pictures of a finished scan.
#pragma once
#include <string>
#include <vector>

#include "base/context.hpp"
#include "base/progress.hpp"
#include "base/result.hpp"
#include "pipeline/scan_results.hpp"
#include "report/scan_report.hpp"

namespace scanmill::pipeline {

/// Writes preview-shaded.png, preview-error.png, preview-patches.png and, where points were removed,
/// preview-removed.png into `folder`; the same pictures for the report.
Result<std::vector<report::Picture>> write_pictures(const ScanResults& results, const std::string& folder,
                                                    const Context& context, Progress& progress);

}  // namespace scanmill::pipeline
