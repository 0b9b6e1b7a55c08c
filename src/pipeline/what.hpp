// SPDX-License-Identifier: Apache-2.0
// The *what* of one scan: everything that decides its bytes, and nothing else.
#pragma once
#include <string>
#include <vector>

#include "base/result.hpp"
#include "document/document.hpp"
#include "grow/params.hpp"
#include "merge/params.hpp"
#include "mesh/limits.hpp"
#include "reduce/params.hpp"

namespace scanmill::pipeline {

enum class Profile : std::int32_t { Scan, Paper };

struct What {
  Profile profile = Profile::Scan;
  double units_mm = 1;               // mm per unit of input files that do not say themselves (a plan does)
  std::string units = "mm";
  bool mesh_vertices_as_scan = false;
  reduce::LatticeParams lattice;
  reduce::Params reduce;
  GrowthLimits grow;
  grow::SeedParams seeds;
  merge::Params merge;
  std::vector<std::string> outputs{"stl"};  // "stl" for now
};

/// Reads the what keys (profile, units, mesh_vertices_as_scan, lattice, reduce, grow, seeds, merge, outputs) of a tree; keys
/// of others are left alone. `profile` sets the defaults, single keys override.
/// errors  BadParameter, all problems at once, one per line: "name:line:column: key: found; allowed; nearest"
Result<What> what_from(const document::Node& root, const std::string& name);
/// Complete tree of the resolved values (defaults filled in); canonical JSON of it enters fingerprints and records.
document::Node to_document(const What& what);
/// Names of the what keys on the top level of a job.
std::span<const std::string_view> what_keys();

}  // namespace scanmill::pipeline
