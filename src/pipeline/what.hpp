// SPDX-License-Identifier: Apache-2.0
// The *what* of one scan: everything that decides its bytes, and nothing else.
#pragma once
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.hpp"
#include "clean/params.hpp"
#include "document/document.hpp"
#include "document/read_fields.hpp"
#include "formats/view_reader.hpp"
#include "grow/params.hpp"
#include "merge/params.hpp"
#include "mesh/limits.hpp"
#include "optimise/params.hpp"
#include "pipeline/discovery.hpp"
#include "pipeline/outputs_key.hpp"
#include "reduce/params.hpp"
#include "refine/params.hpp"
#include "verify/params.hpp"

namespace scanmill::pipeline {

enum class Profile : std::int32_t { Scan, Paper };

/// The job's `sensor` section: what verification says beside the fit error.
struct Sensor {
  double accuracy_mm = verify::kPaperAccuracy;
  static std::span<const Field> fields();
};

struct What {
  Profile profile = Profile::Scan;
  double units_mm = 1;  // mm per unit of input files that do not say themselves (a plan does)
  std::string units = "mm";
  bool mesh_vertices_as_scan = false;
  formats::Format format = formats::Format::Auto;
  std::vector<ViewsSpec> views;
  std::optional<formats::DepthCamera> camera;  // of depth maps named on the command line; a job says it in views
  refine::Params refine;
  clean::Params clean;
  reduce::LatticeParams lattice;
  reduce::Params reduce;
  GrowthLimits grow;
  grow::SeedParams seeds;
  merge::Params merge;
  optimise::Params optimise;
  verify::Params verify;
  Sensor sensor;
  std::vector<Output> outputs{{"stl", false}};
  std::vector<std::string> previews{preview_words().begin(), preview_words().end()};
};

/// Reads the what keys (what_keys()) of a tree; keys of others are left alone. `profile` sets the defaults, single keys
/// override. `needs_bin` false: a tree without a bin size is fine (tools that do not bin).
/// errors  BadParameter, all problems at once, one per line: "name:line:column: key: found; allowed; nearest"
Result<What> what_from(const document::Node& root, const std::string& name, bool needs_bin = true);
/// The problems of a tree that need not be complete (an entry of `overrides`): the same lines, but no bin size is asked
/// for.
void check_part(const document::Node& part, document::Problems& problems);
/// `base` with the keys of `over`: maps are joined, other values replaced; a key of a group that excludes each other
/// (bin_mm, target_points, target_bins; min_normal_dot, max_normal_deg) takes the place of the group's others.
document::Node overlay_what(document::Node base, const document::Node& over);
/// The keys that discovery needs, out of a tree that need not be complete or sound: keys with problems keep their
/// defaults.
DiscoveryKeys discovery_keys(const document::Node& root);
/// The keys that decide the bytes of one scan: entries of `views` for other scans do not.
What what_for(What what, const std::string& scan);
/// Complete tree of the resolved values (defaults filled in); canonical JSON of it enters fingerprints and records.
document::Node to_document(const What& what);
/// Names of the what keys on the top level of a job.
std::span<const std::string_view> what_keys();
/// Draft-07 schemas of the what keys, in the order of what_keys(): the `properties` of a job.
document::Node what_schema();

/// One key with its section, for options of the command line that carry the job's names; section "" for the top level.
struct WhatField {
  std::string_view section;
  const Field* field;
};
std::vector<WhatField> what_fields();
/// The words that `profile` and `units` take.
std::span<const std::string_view> profile_words();
std::span<const std::string_view> unit_words();

}  // namespace scanmill::pipeline
