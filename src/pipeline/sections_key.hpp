// SPDX-License-Identifier: Apache-2.0
// The job's `verify.sections`.
#pragma once
#include <string>
#include <vector>

#include "document/document.hpp"
#include "document/read_fields.hpp"
#include "verify/section_rule.hpp"

namespace scanmill::pipeline {

/// A list of maps, or one map: `axis` (x, y, z or a direction) with one of `at_mm`, `count` or `through` (worst, loop
/// or a point), and `slab_mm`, `magnify`, `name` as wanted. Problems go to `problems`.
std::vector<verify::SectionRule> read_sections(const document::Node& value, document::Problems& problems);
/// The same from words of a command line, one rule each: AXIS=PLACE with axis x, y, z or a direction a,b,c and place a
/// position in mm, worst, loop, a point a,b,c, or 3x for three planes spread evenly; or a map as in the job.
/// errors  BadParameter, a line each, with "command line" as place
Result<std::vector<verify::SectionRule>> sections_from_words(const std::vector<std::string>& words);
document::Node sections_to_document(const std::vector<verify::SectionRule>& rules);
document::Node sections_schema();

}  // namespace scanmill::pipeline
