// SPDX-License-Identifier: Apache-2.0
// The pictures of a finished scan.
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "base/context.hpp"
#include "base/progress.hpp"
#include "base/result.hpp"
#include "pipeline/run_scan.hpp"
#include "pipeline/scan_results.hpp"
#include "report/scan_report.hpp"

namespace scanmill::pipeline {

/// Writes the job's previews (preview-shaded.png, preview-error.png, preview-patches.png) and, where points were
/// removed, preview-removed.png into `folder`; the same pictures for the report.
Result<std::vector<report::Picture>> write_pictures(const ScanResults& results, const std::string& folder,
                                                    const Context& context, Progress& progress);

/// Whether write_pictures gives this name to a file.
bool is_picture(std::string_view name);

/// The first picture that the job asks for and an earlier result does not have; empty when it has all.
std::string picture_missing(const Previous& previous, const What& what);

/// The pictures that the job asks for of an earlier result of the same mesh, copied into `folder`.
Result<std::vector<report::Picture>> copy_pictures(const Previous& previous, const What& what,
                                                   const std::string& folder);

}  // namespace scanmill::pipeline
