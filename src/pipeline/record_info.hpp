// SPDX-License-Identifier: Apache-2.0
// What a record says of itself, for `info`; `audit` proves it.
#pragma once
#include <string>

#include "pipeline/tools.hpp"

namespace scanmill::pipeline {

/// Whether a file begins as HDF5 files do.
Result<bool> is_record_file(const std::string& path);

/// Scan, maker, identity, whether the content still digests to what the file says, sizes of what it holds, versions of
/// the stages, inputs and outputs. Reads the whole file once, for the digest.
/// errors  IoFailed, BadInput for a file that is no record
Result<ToolReport> record_info(const std::string& path, Progress& progress);

}  // namespace scanmill::pipeline
