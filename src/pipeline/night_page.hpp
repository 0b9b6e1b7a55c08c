// SPDX-License-Identifier: Apache-2.0
// The page of a run, filled from what the runner wrote down.
#pragma once
#include <string>

#include "document/document.hpp"

namespace scanmill::pipeline {

/// `night`: a run.json, with or without what runner/night.hpp adds. A key that is missing or no value of its kind
/// counts as unknown.
std::string night_page(const document::Node& night);

}  // namespace scanmill::pipeline
