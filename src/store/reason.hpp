// SPDX-License-Identifier: Apache-2.0
// What the system said, as an Error. Only for files of `store`.
#pragma once
#include <string>

#include "base/result.hpp"

namespace scanmill::store {

/// "cannot <doing>: <reason of the system>" at `path`; NoSpace for a full disk or quota, IoFailed otherwise.
Error system_failure(int error_number, const std::string& doing, const std::string& path);

}  // namespace scanmill::store
