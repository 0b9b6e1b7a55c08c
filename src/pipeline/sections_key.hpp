// SPDX-License-Identifier: Apache-2.0
// The job's `verify.sections`.
#pragma once
#include <vector>

#include "document/document.hpp"
#include "document/read_fields.hpp"
#include "verify/section_rule.hpp"

namespace scanmill::pipeline {

/// A list of maps, or one map: `axis` (x, y, z or a direction) with one of `at_mm`, `count` or `through` (worst, loop
/// or a point), and `slab_mm`, `magnify`, `name` as wanted. Problems go to `problems`.
std::vector<verify::SectionRule> read_sections(const document::Node& value, document::Problems& problems);
document::Node sections_to_document(const std::vector<verify::SectionRule>& rules);
document::Node sections_schema();

}  // namespace scanmill::pipeline
