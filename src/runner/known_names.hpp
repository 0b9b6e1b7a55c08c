// SPDX-License-Identifier: Apache-2.0
// OUT/journal/names.json: the scans that the archive held when a run last looked at all of it.
#pragma once
#include <set>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "runner/output_tree.hpp"

namespace scanmill::runner {

/// Empty when there is no list that can be read.
std::set<std::string> load_names(const OutputTree& tree);
/// errors  IoFailed, NoSpace naming the file
Result<void> save_names(const std::vector<std::string>& names, const OutputTree& tree);

}  // namespace scanmill::runner
