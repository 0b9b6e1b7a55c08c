// SPDX-License-Identifier: Apache-2.0
// The what keys as draft-07 schemas, from the same tables that read them.
#include "document/read_fields.hpp"
#include "pipeline/clean_keys.hpp"
#include "pipeline/sections_key.hpp"
#include "pipeline/what.hpp"

namespace scanmill::pipeline {
namespace {

using document::Node;

Node words_schema(std::span<const std::string_view> words, const char* help, std::string_view preset) {
  Node schema = Node::map();
  schema.set("description", help);
  Node list = Node::sequence();
  for (const std::string_view word : words) list.push(word);
  schema.set("enum", std::move(list));
  schema.set("default", preset);
  return schema;
}

Node constant(const char* word) {
  Node schema = Node::map();
  schema.set("const", word);
  return schema;
}

Node any_of(std::initializer_list<Node> choices) {
  Node list = Node::sequence();
  for (const Node& choice : choices) list.push(choice);
  Node schema = Node::map();
  schema.set("anyOf", std::move(list));
  return schema;
}

Node points_schema() {
  Node number = Node::map();
  number.set("type", "number");
  Node point = Node::map();
  point.set("type", "array");
  point.set("items", std::move(number));
  point.set("minItems", 3);
  point.set("maxItems", 3);
  Node list = Node::map();
  list.set("type", "array");
  list.set("items", std::move(point));
  list.set("minItems", 1);
  return list;
}

Node seeds_schema() {
  const grow::SeedParams defaults;
  Node map = document::fields_schema(grow::SeedParams::fields(), &defaults, "Seeds with their rules.");
  map.find("properties")->set("points", any_of({constant("auto"), points_schema()}));
  Node schema = any_of({constant("auto"), points_schema(), map});
  schema.set("description", "First points of the patches, global frame, mm: auto, a list of points, or a map.");
  schema.set("default", "auto");
  return schema;
}

}  // namespace

Node what_schema() {
  const What defaults;
  Node properties = Node::map();
  auto section = [&](const char* key, std::span<const Field> table, const void* object, const char* help) {
    properties.set(key, document::fields_schema(table, object, help));
  };
  auto top = [&](std::string_view key) {
    for (const WhatField& row : what_fields())
      if (row.section.empty() && row.field->name == key)
        properties.set(key, document::field_schema(*row.field, &defaults));
  };
  top("profile");
  properties.set("units",
                 words_schema(unit_words(), "Length unit of input files that do not say it themselves.", "mm"));
  top("mesh_vertices_as_scan");
  top("format");
  properties.set("views", views_schema());
  section("refine", refine::Params::fields(), &defaults.refine,
          "Poses of views moved, within the machine's accuracy, to where the views fit each other.");
  properties.set("clean", clean_schema());
  section("lattice", reduce::LatticeParams::fields(), &defaults.lattice,
          "Bins; exactly one of bin_mm, target_points, target_bins.");
  section("reduce", reduce::Params::fields(), &defaults.reduce, "Which point of each bin is kept.");
  section("grow", GrowthLimits::fields(), &defaults.grow,
          "Which triangles are refused; min_normal_dot and max_normal_deg exclude each other.");
  properties.set("seeds", seeds_schema());
  section("merge", merge::Params::fields(), &defaults.merge, "How patches and pieces become one mesh.");
  section("optimise", optimise::Params::fields(), &defaults.optimise, "Edge swaps on the finished mesh.");
  section("verify", verify::Params::fields(), &defaults.verify,
          "Gates: a mesh beyond one is kept, marked as rejected, and the run ends with exit code 4.");
  properties.find("verify")->find("properties")->set("sections", sections_schema());
  section("sensor", Sensor::fields(), &defaults.sensor, "What is known of the sensor.");
  properties.set("outputs", outputs_schema());
  properties.set("previews", previews_schema());
  return properties;
}

}  // namespace scanmill::pipeline
