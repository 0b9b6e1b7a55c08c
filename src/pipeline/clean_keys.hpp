// SPDX-License-Identifier: Apache-2.0
// The job's `clean` section: from a tree, back, and as a schema.
#pragma once
#include "clean/params.hpp"
#include "document/document.hpp"
#include "document/read_fields.hpp"

namespace scanmill::pipeline {

/// Reads keep_box, remove_box (a box or a list), remove_plane and outliers; each may be `off`. `complete` false: a part
/// of a job (an entry of `overrides`), whose rules need not be whole.
void read_clean(const document::Node& section, bool complete, clean::Params& params, document::Problems& problems);
/// The rules that are given, complete; an empty map without any.
document::Node clean_to_document(const clean::Params& params);
/// Draft-07.
document::Node clean_schema();

}  // namespace scanmill::pipeline
