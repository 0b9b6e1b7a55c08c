// SPDX-License-Identifier: Apache-2.0
#include "pipeline/what.hpp"

#include <algorithm>

#include "base/text.hpp"
#include "pipeline/clean_keys.hpp"
#include "pipeline/sections_key.hpp"
#include "plan/plan.hpp"

namespace scanmill::pipeline {
namespace {

using document::Node;
using document::Problems;
using document::shown;

constexpr std::string_view kKeys[] = {"profile",  "units",   "mesh_vertices_as_scan",
                                      "format",   "views",   "refine",
                                      "clean",    "lattice", "reduce",
                                      "grow",     "seeds",   "merge",
                                      "optimise", "verify",  "sensor",
                                      "outputs",  "previews"};
constexpr std::string_view kProfiles[] = {"scan", "paper"};
constexpr std::string_view kUnits[] = {"mm", "cm", "m", "um", "in"};
constexpr std::string_view kPointsKey[] = {"points"};
constexpr std::string_view kSectionsKey[] = {"sections"};
constexpr std::string_view kLaterMerge = "fill_holes_up_to_bins";

/// Keys of one section that exclude each other.
struct Exclusive {
  std::string_view section;
  std::span<const std::string_view> keys;
};
constexpr std::string_view kBinKeys[] = {"bin_mm", "target_points", "target_bins"};
constexpr std::string_view kNormalKeys[] = {"min_normal_dot", "max_normal_deg"};
constexpr Exclusive kExclusive[] = {{"lattice", kBinKeys}, {"grow", kNormalKeys}};

std::span<const Field> top_fields() {
  static const Field kTable[] = {
      field<What, &What::profile>(
          "profile", "",
          "scan: what evidence says is best on raw scans; paper: the paper's own rules. Single keys override either.",
          {}, kProfiles),
      field<What, &What::mesh_vertices_as_scan>("mesh_vertices_as_scan", "",
                                                "Take the vertices of files that hold a mesh as a scan."),
      field<What, &What::format>("format", "",
                                 "Format of the input files; auto judges each by its content, then by its suffix.", {},
                                 formats::format_words()),
  };
  return kTable;
}

bool is_given(const Node* node) {
  return node && !node->is_null() && !(node->is_string() && node->as_string() == "off");
}

std::vector<std::string_view> given_of(const Node& root, const Exclusive& group) {
  std::vector<std::string_view> given;
  if (const Node* section = root.find(group.section))
    for (const std::string_view key : group.keys)
      if (is_given(section->find(key))) given.push_back(key);
  return given;
}

void read_units(const Node& value, What& what, Problems& problems) {
  if (value.is_string())
    if (std::find(std::begin(kUnits), std::end(kUnits), value.as_string()) != std::end(kUnits)) {
      what.units = value.as_string();
      what.units_mm = plan::unit_mm(what.units).value_or(1);
      return;
    }
  std::string sentence = "found " + shown(value) + "; allowed " + document::joined(kUnits);
  const std::string_view nearest = value.is_string() ? nearest_name(value.as_string(), kUnits) : "";
  if (!nearest.empty()) sentence += "; nearest " + std::string(nearest);
  problems.add(value.mark, "units", sentence);
}

void read_points(const Node& list, const std::string& key, grow::SeedParams& seeds, Problems& problems) {
  if (list.is_string() && list.as_string() == "auto") return;
  if (!list.is_sequence() || list.items().empty()) {
    problems.add(list.mark, key, "found " + shown(list) + "; allowed auto, a list of points [x, y, z] in mm");
    return;
  }
  for (const Node& item : list.items()) {
    const bool numbers =
        item.is_sequence() && item.items().size() == 3 &&
        std::all_of(item.items().begin(), item.items().end(), [](const Node& n) { return n.is_number(); });
    const Vec3 point =
        numbers ? Vec3{item.items()[0].as_number(), item.items()[1].as_number(), item.items()[2].as_number()} : Vec3{};
    if (numbers && is_finite(point))
      seeds.points.push_back(point);
    else
      problems.add(item.mark, key, "found " + shown(item) + "; allowed three numbers [x, y, z] in mm");
  }
}

void read_seeds(const Node& value, grow::SeedParams& seeds, Problems& problems) {
  if (!value.is_map()) return read_points(value, "seeds", seeds, problems);
  document::read_fields(value, "seeds", grow::SeedParams::fields(), &seeds, kPointsKey, problems);
  if (const Node* points = value.find("points")) read_points(*points, "seeds.points", seeds, problems);
}

void set_profile(What& what) {
  if (what.profile == Profile::Scan) return;
  what.reduce = reduce::Params::paper();
  what.grow.range_bins = 2;
  what.lattice.origin = reduce::Origin::Bounds;
}

void read_merge(const Node& section, What& what, Problems& problems) {
  Node known = section;
  if (const Node* later = section.find(kLaterMerge)) {
    problems.add(later->mark, "merge." + std::string(kLaterMerge), "not in this version; remove the key");
    std::erase_if(known.entries(), [](const Node::Entry& entry) { return entry.key == kLaterMerge; });
  }
  document::read_fields(known, "merge", merge::Params::fields(), &what.merge, {}, problems);
}

void read_verify(const Node& section, What& what, Problems& problems) {
  document::read_fields(section, "verify", verify::Params::fields(), &what.verify, kSectionsKey, problems);
  if (const Node* sections = section.is_map() ? section.find("sections") : nullptr)
    what.verify.sections = read_sections(*sections, problems);
}

/// Everything that can be judged on a part of a job; `complete` when it is a whole one.
What read(const Node& root, bool complete, Problems& problems) {
  What what;
  if (!root.is_map()) {
    problems.add(root.mark, "", "found " + shown(root) + "; wanted a map of keys, such as lattice: {bin_mm: 1}");
    return what;
  }
  for (const Field& row : top_fields())
    if (const Node* value = root.find(row.name))
      document::read_field(*value, std::string(row.name), row, &what, problems);
  set_profile(what);
  if (const Node* value = root.find("views")) what.views = read_views(*value, problems);
  if (const Node* value = root.find("units")) read_units(*value, what, problems);
  if (const Node* value = root.find("clean")) read_clean(*value, complete, what.clean, problems);
  auto section = [&](std::string_view key, std::span<const Field> table, void* object) {
    if (const Node* value = root.find(key))
      document::read_fields(*value, std::string(key), table, object, {}, problems);
  };
  section("refine", refine::Params::fields(), &what.refine);
  section("lattice", reduce::LatticeParams::fields(), &what.lattice);
  section("reduce", reduce::Params::fields(), &what.reduce);
  section("grow", GrowthLimits::fields(), &what.grow);
  if (const Node* value = root.find("seeds")) read_seeds(*value, what.seeds, problems);
  if (const Node* value = root.find("merge")) read_merge(*value, what, problems);
  section("optimise", optimise::Params::fields(), &what.optimise);
  if (const Node* value = root.find("verify")) read_verify(*value, what, problems);
  section("sensor", Sensor::fields(), &what.sensor);
  if (const Node* value = root.find("outputs")) what.outputs = read_outputs(*value, problems);
  if (const Node* value = root.find("previews")) what.previews = read_previews(*value, problems);
  for (const Exclusive& group : kExclusive) {
    const auto given = given_of(root, group);
    if (given.size() > 1)
      problems.add(root.find(group.section)->mark, std::string(group.section),
                   "found " + document::joined(given) + "; they exclude each other: keep one");
  }
  return what;
}

}  // namespace

Result<What> what_from(const Node& root, const std::string& name, bool needs_bin) {
  Problems problems(name);
  What what = read(root, true, problems);
  if (needs_bin && given_of(root, kExclusive[0]).empty()) {
    const Node* lattice = root.find("lattice");
    problems.add(
        lattice ? lattice->mark : root.mark, "lattice",
        "found no bin size; one of " + document::joined(kBinKeys) + " must be given, e.g. lattice: {bin_mm: 1}");
  }
  if (needs_bin && what.clean.outliers && !what.clean.outliers->bin_mm && !what.lattice.bin_mm)
    problems.add(root.find("clean")->mark, "clean.outliers",
                 "found no bin edge; give clean.outliers.bin_mm, since lattice.bin_mm is not given");
  if (!problems.empty()) return problems.error();
  return what;
}

void check_part(const Node& part, Problems& problems) { (void)read(part, false, problems); }

DiscoveryKeys discovery_keys(const Node& root) {
  Problems ignored("");
  What what = read(root, false, ignored);
  return {what.mesh_vertices_as_scan, what.format, std::move(what.views), {}};
}

What what_for(What what, const std::string& scan) {
  std::erase_if(what.views, [&](const ViewsSpec& spec) { return spec.name != scan; });
  return what;
}

namespace {
void overlay(Node& base, const Node& over) {
  if (!base.is_map() || !over.is_map()) {
    base = over;
    return;
  }
  for (const Node::Entry& entry : over.entries()) {
    if (Node* present = base.find(entry.key))
      overlay(*present, entry.value);
    else
      base.entries().push_back(entry);
  }
}
}  // namespace

Node overlay_what(Node base, const Node& over) {
  if (base.is_null()) base = Node::map();
  for (const Exclusive& group : kExclusive) {
    Node* section = base.find(group.section);
    if (!section || !section->is_map() || given_of(over, group).empty()) continue;
    std::erase_if(section->entries(), [&](const Node::Entry& entry) {
      return std::find(group.keys.begin(), group.keys.end(), entry.key) != group.keys.end();
    });
  }
  overlay(base, over);
  return base;
}

Node to_document(const What& what) {
  Node tree = Node::map();
  tree.set("profile", kProfiles[static_cast<std::size_t>(what.profile)]);
  tree.set("units", what.units);
  tree.set("mesh_vertices_as_scan", what.mesh_vertices_as_scan);
  tree.set("format", formats::format_words()[static_cast<std::size_t>(what.format)]);
  if (!what.views.empty()) tree.set("views", to_document(what.views));
  if (what.refine.poses)  // nothing of it decides any byte otherwise
    tree.set("refine", document::fields_to_document(refine::Params::fields(), &what.refine));
  tree.set("clean", clean_to_document(what.clean));
  tree.set("lattice", document::fields_to_document(reduce::LatticeParams::fields(), &what.lattice));
  tree.set("reduce", document::fields_to_document(reduce::Params::fields(), &what.reduce));
  Node grow = document::fields_to_document(GrowthLimits::fields(), &what.grow);
  if (what.grow.max_normal_deg)  // the angle wins; the dot product it hides is not part of the result
    std::erase_if(grow.entries(), [](const Node::Entry& entry) { return entry.key == "min_normal_dot"; });
  tree.set("grow", std::move(grow));
  Node seeds = document::fields_to_document(grow::SeedParams::fields(), &what.seeds);
  Node points = Node::sequence();
  for (const Vec3& p : what.seeds.points) {
    Node point = Node::sequence();
    for (const double v : {p.x, p.y, p.z}) point.push(v);
    points.push(std::move(point));
  }
  seeds.set("points", what.seeds.points.empty() ? Node("auto") : std::move(points));
  tree.set("seeds", std::move(seeds));
  tree.set("merge", document::fields_to_document(merge::Params::fields(), &what.merge));
  tree.set("optimise", document::fields_to_document(optimise::Params::fields(), &what.optimise));
  Node& verify = tree.set("verify", document::fields_to_document(verify::Params::fields(), &what.verify));
  if (!what.verify.sections.empty()) verify.set("sections", sections_to_document(what.verify.sections));
  tree.set("sensor", document::fields_to_document(Sensor::fields(), &what.sensor));
  tree.set("outputs", outputs_to_document(what.outputs));
  Node& previews = tree.set("previews", Node::sequence());
  for (const std::string& word : what.previews) previews.push(word);
  return tree;
}

std::span<const Field> Sensor::fields() {
  static const Field kTable[] = {
      field<Sensor, &Sensor::accuracy_mm>("accuracy_mm", "",
                                          "Accuracy of the sensor, stated beside the fit error and added to it (the "
                                          "paper's: 0.0508).",
                                          {0, 1e6}),
  };
  return kTable;
}

std::span<const std::string_view> what_keys() { return kKeys; }
std::span<const std::string_view> profile_words() { return kProfiles; }
std::span<const std::string_view> unit_words() { return kUnits; }

std::vector<WhatField> what_fields() {
  std::vector<WhatField> all;
  auto add = [&](std::string_view section, std::span<const Field> table) {
    for (const Field& row : table) all.push_back({section, &row});
  };
  add("", top_fields());
  add("refine", refine::Params::fields());
  add("lattice", reduce::LatticeParams::fields());
  add("reduce", reduce::Params::fields());
  add("grow", GrowthLimits::fields());
  add("seeds", grow::SeedParams::fields());
  add("merge", merge::Params::fields());
  add("optimise", optimise::Params::fields());
  add("verify", verify::Params::fields());
  add("sensor", Sensor::fields());
  return all;
}

}  // namespace scanmill::pipeline
