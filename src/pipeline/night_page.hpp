// SPDX-License-Identifier: Apache-2.0
// The page of a run, filled from what the runner wrote down.
#pragma once
#include <cstddef>
#include <functional>
#include <string>

#include "document/document.hpp"

namespace scanmill::pipeline {

/// `night`: a run.json without its scans, with or without what runner/night.hpp adds; `scan_at(k)`: its k-th scan of
/// `scans`, asked for once each, in order. A key that is missing or no value of its kind counts as unknown.
std::string night_page(const document::Node& night, std::size_t scans,
                       const std::function<document::Node(std::size_t)>& scan_at);

}  // namespace scanmill::pipeline
