// SPDX-License-Identifier: Apache-2.0
// Names of scans from the paths of the files that make them.
#pragma once
#include <string>
#include <vector>

namespace scanmill::pipeline {

/// One name per path, in the same order: the path without suffix; with it where two paths of one folder share the rest,
/// or where the rest is also the folder of another path. Bytes outside [A-Za-z0-9._/-] become %XX.
std::vector<std::string> scan_names(const std::vector<std::string>& paths);
/// Per path, in the same order: empty, or a sentence naming another path whose scan's name differs by letter case only.
std::vector<std::string> case_clashes(const std::vector<std::string>& names, const std::vector<std::string>& paths);

}  // namespace scanmill::pipeline
