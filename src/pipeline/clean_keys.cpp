// SPDX-License-Identifier: Apache-2.0
#include "pipeline/clean_keys.hpp"

#include <algorithm>

#include "pipeline/tool_inputs.hpp"

namespace scanmill::pipeline {
namespace {

using document::Node;
using document::Problems;
using document::shown;

constexpr std::string_view kRules[] = {"keep_box", "remove_box", "remove_plane", "outliers"};
constexpr std::string_view kBoxKeys[] = {"min", "max"};
constexpr std::string_view kPlaneVectors[] = {"point", "normal"};
constexpr std::string_view kStatistical[] = {"statistical"};

bool is_off(const Node& node) { return node.is_null() || (node.is_string() && node.as_string() == "off"); }

std::optional<Vec3> read_triple(const Node& value, const std::string& key, const char* meaning, Problems& problems) {
  const bool numbers =
      value.is_sequence() && value.items().size() == 3 &&
      std::all_of(value.items().begin(), value.items().end(), [](const Node& n) { return n.is_number(); });
  const Vec3 triple =
      numbers ? Vec3{value.items()[0].as_number(), value.items()[1].as_number(), value.items()[2].as_number()} : Vec3{};
  if (numbers && is_finite(triple)) return triple;
  problems.add(value.mark, key, "found " + shown(value) + "; allowed three numbers [x, y, z]" + meaning);
  return std::nullopt;
}

std::optional<clean::Box> read_box(const Node& value, const std::string& key, bool complete, Problems& problems) {
  document::read_fields(value, key, {}, nullptr, kBoxKeys, problems);
  if (!value.is_map()) return std::nullopt;
  std::optional<Vec3> corners[2];
  for (std::size_t i = 0; i < 2; ++i) {
    const std::string name(kBoxKeys[i]);
    if (const Node* corner = value.find(name))
      corners[i] = read_triple(*corner, key + "." + name, " in mm", problems);
    else if (complete)
      problems.add(value.mark, key, "found no " + name + "; wanted min: [x, y, z] and max: [x, y, z] in mm");
  }
  if (!corners[0] || !corners[1]) return std::nullopt;
  const Vec3 size = *corners[1] - *corners[0];
  if (size.x > 0 && size.y > 0 && size.z > 0) return clean::Box{*corners[0], *corners[1]};
  problems.add(value.mark, key, "found a min that is not below max on each axis; such a box holds nothing");
  return std::nullopt;
}

void read_boxes(const Node& value, bool complete, std::vector<clean::Box>& boxes, Problems& problems) {
  auto add = [&](const Node& item, const std::string& key) {
    if (const auto box = read_box(item, key, complete, problems)) boxes.push_back(*box);
  };
  if (!value.is_sequence()) return add(value, "clean.remove_box");
  for (std::size_t i = 0; i < value.items().size(); ++i)
    add(value.items()[i], "clean.remove_box[" + std::to_string(i) + "]");
}

std::optional<clean::PlaneRule> read_plane(const Node& value, bool complete, Problems& problems) {
  const std::string key = "clean.remove_plane";
  clean::PlaneRule rule;
  document::read_fields(value, key, clean::PlaneRule::fields(), &rule, kPlaneVectors, problems);
  if (!value.is_map()) return std::nullopt;
  const Node *point = value.find("point"), *normal = value.find("normal");
  if (point) rule.point = read_triple(*point, key + ".point", " in mm", problems);
  if (normal) rule.normal = read_triple(*normal, key + ".normal", ", a direction", problems);
  if (rule.normal && !(norm2(*rule.normal) > 0)) {
    problems.add(normal->mark, key + ".normal", "found a zero vector; allowed a direction [x, y, z]");
    rule.normal.reset();
  }
  if (!complete) return rule;
  if (!value.find("distance_mm"))
    problems.add(value.mark, key, "found no distance_mm; it must be given, e.g. distance_mm: 0.5");
  if (rule.fit && point) problems.add(point->mark, key, "found fit: true and point; they exclude each other: keep one");
  if (!rule.fit && !(point && normal))
    problems.add(value.mark, key, "found no plane; wanted fit: true, or point: [x, y, z] and normal: [x, y, z]");
  return rule;
}

std::optional<clean::OutlierRules> read_outliers(const Node& value, bool complete, Problems& problems) {
  const std::string key = "clean.outliers";
  clean::OutlierRules rules;
  document::read_fields(value, key, clean::OutlierRules::fields(), &rules, kStatistical, problems);
  if (!value.is_map()) return std::nullopt;
  bool asked = false;
  if (const Node* section = value.find("statistical"); section && !is_off(*section)) {
    asked = true;
    clean::StatisticalRule rule;
    document::read_fields(*section, key + ".statistical", clean::StatisticalRule::fields(), &rule, {}, problems);
    rules.statistical = rule;
  }
  for (const char* name : {"min_component_points", "min_component_share"})
    if (const Node* given = value.find(name)) asked |= !is_off(*given);
  if (!asked && complete)
    problems.add(value.mark, key,
                 "found no rule; wanted statistical: {neighbours: 8, deviations: 3}, min_component_points or "
                 "min_component_share");
  return rules;
}

Node box_node(const clean::Box& box) {
  Node map = Node::map();
  map.set("min", triple(box.low));
  map.set("max", triple(box.high));
  return map;
}

Node triple_schema(const char* help) {
  Node number = Node::map();
  number.set("type", "number");
  Node list = Node::map();
  list.set("description", help);
  list.set("type", "array");
  list.set("items", std::move(number));
  list.set("minItems", 3);
  list.set("maxItems", 3);
  return list;
}

Node box_schema(const char* help) {
  Node box = document::fields_schema({}, nullptr, help);
  Node* properties = box.find("properties");
  properties->set("min", triple_schema("Lowest corner, mm; belongs to the box."));
  properties->set("max", triple_schema("Highest corner, mm; does not belong to the box."));
  return box;
}

/// One of `choices`, or off.
Node or_off(std::initializer_list<Node> choices) {
  Node words = Node::sequence();
  words.push("off");
  words.push(Node());
  Node off = Node::map();
  off.set("enum", std::move(words));
  Node list = Node::sequence();
  for (const Node& choice : choices) list.push(choice);
  list.push(std::move(off));
  Node schema = Node::map();
  schema.set("anyOf", std::move(list));
  return schema;
}

}  // namespace

void read_clean(const Node& section, bool complete, clean::Params& params, Problems& problems) {
  document::read_fields(section, "clean", {}, nullptr, kRules, problems);
  if (!section.is_map()) return;
  auto given = [&](std::string_view key) {
    const Node* value = section.find(key);
    return value && !is_off(*value) ? value : nullptr;
  };
  if (const Node* value = given("keep_box")) params.keep_box = read_box(*value, "clean.keep_box", complete, problems);
  if (const Node* value = given("remove_box")) read_boxes(*value, complete, params.remove_box, problems);
  if (const Node* value = given("remove_plane")) params.remove_plane = read_plane(*value, complete, problems);
  if (const Node* value = given("outliers")) params.outliers = read_outliers(*value, complete, problems);
}

Node clean_to_document(const clean::Params& params) {
  Node tree = Node::map();
  if (params.keep_box) tree.set("keep_box", box_node(*params.keep_box));
  if (!params.remove_box.empty()) {
    Node list = Node::sequence();
    for (const clean::Box& box : params.remove_box) list.push(box_node(box));
    tree.set("remove_box", std::move(list));
  }
  if (params.remove_plane) {
    const clean::PlaneRule& rule = *params.remove_plane;
    Node map = document::fields_to_document(clean::PlaneRule::fields(), &rule);
    if (rule.point) map.set("point", triple(*rule.point));
    if (rule.normal) map.set("normal", triple(*rule.normal));
    tree.set("remove_plane", std::move(map));
  }
  if (params.outliers) {
    Node map = document::fields_to_document(clean::OutlierRules::fields(), &*params.outliers);
    if (params.outliers->statistical)
      map.set("statistical",
              document::fields_to_document(clean::StatisticalRule::fields(), &*params.outliers->statistical));
    tree.set("outliers", std::move(map));
  }
  return tree;
}

/// Nothing is `required`: an entry of `overrides` may give a part of a rule; check_part and what_from tell them apart.
Node clean_schema() {
  Node schema = document::fields_schema({}, nullptr, "Points of fixture and deck, and outliers, taken out by rule.");
  Node* properties = schema.find("properties");
  properties->set("keep_box", or_off({box_schema("Points outside go.")}));
  const Node box = box_schema("Points inside go.");
  Node list = Node::map();
  list.set("type", "array");
  list.set("items", box);
  properties->set("remove_box", or_off({box, list}));

  clean::PlaneRule plane_defaults;
  Node plane = document::fields_schema(clean::PlaneRule::fields(), &plane_defaults,
                                       "Points of a plane go: the one of point and normal, or with fit the one that "
                                       "holds most points.");
  std::erase_if(plane.find("properties")->find("distance_mm")->entries(),
                [](const Node::Entry& entry) { return entry.key == "default"; });
  plane.find("properties")->set("point", triple_schema("A point of the plane, mm."));
  plane.find("properties")->set("normal", triple_schema("Upwards; with fit, the direction the plane faces about."));
  properties->set("remove_plane", or_off({plane}));

  const clean::OutlierRules outlier_defaults;
  const clean::StatisticalRule statistical_defaults;
  Node outliers = document::fields_schema(clean::OutlierRules::fields(), &outlier_defaults,
                                          "Lone points and small pieces go; judged on bins.");
  outliers.find("properties")
      ->set("statistical",
            or_off({document::fields_schema(clean::StatisticalRule::fields(), &statistical_defaults,
                                            "Points far from their neighbours, as the whole cloud goes.")}));
  properties->set("outliers", or_off({outliers}));
  return schema;
}

}  // namespace scanmill::pipeline
