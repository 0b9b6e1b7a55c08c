// SPDX-License-Identifier: Apache-2.0
// Damaged records can crash the library that reads them; better a child of ours than us.
#pragma once
#include <cstdint>
#include <functional>
#include <string>

#include "base/result.hpp"

namespace scanmill::provenance {

/// Runs `reading` in a child process, which must not start threads and whose work is lost. True of it: what it did,
/// this process can do too. `bytes` of the file bound the time it gets.
/// errors  BadInput naming `path` when the child crashed, hung or said no; IoFailed when there can be no child
Result<void> try_in_child(const std::string& path, std::uint64_t bytes, const std::function<bool()>& reading);

}  // namespace scanmill::provenance
