// SPDX-License-Identifier: Apache-2.0
#include "cli/stage_options.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>

#include "base/text.hpp"

namespace scanmill::cli {

using document::Node;

namespace {

std::string option_name(std::string_view key) {
  std::string name = "--" + std::string(key);
  std::replace(name.begin(), name.end(), '_', '-');
  return name;
}

std::string help_text(const Field& field) {
  std::string help(field.help);
  if (!field.symbol.empty()) help += " (" + std::string(field.symbol) + ")";
  if (!field.words.empty()) help += " One of " + document::joined(field.words) + ".";
  return help;
}

/// A value as the job would hold it, without a place in a text.
Node value_of(const std::string& text) {
  auto tree = document::parse_yaml("value: " + text, "command line");
  Node value = tree && tree->find("value") ? *tree->find("value") : Node(text);
  value.mark = {};
  return value;
}

}  // namespace

void StageOptions::add_to(CLI::App& command, std::initializer_list<std::string_view> sections) {
  const auto has = [&](std::string_view section) {
    return std::find(sections.begin(), sections.end(), section) != sections.end();
  };
  if (has(""))
    command.add_option(
        "--units", units_,
        "Length unit of files that do not say it themselves: " + document::joined(pipeline::unit_words()) + ".");
  if (has("")) {
    command.add_option("--intrinsics", intrinsics_, "Camera of depth maps (16-bit PNG): fx,fy,cx,cy in pixels.")
        ->allow_extra_args(false);
    command.add_option("--depth-scale", depth_scale_,
                       "Pixel values of a depth map per unit of length; 1000 if not given.");
  }
  for (const pipeline::WhatField& key : pipeline::what_fields()) {
    if (!has(key.section)) continue;
    given_.push_back(std::make_unique<Given>(Given{key, option_name(key.field->name), {}}));
    Given& row = *given_.back();
    const bool is_flag = std::holds_alternative<bool* (*)(void*)>(key.field->member);
    const std::string help = help_text(*key.field);
    if (is_flag)
      command.add_flag(row.option, row.text, help)->group("Stage options");
    else
      command.add_option(row.option, row.text, help)->group("Stage options");
  }
  if (has("seeds"))
    command.add_option("--seed", seeds_, "First point of a patch, x,y,z in mm; may be given again.")
        ->group("Stage options")
        ->allow_extra_args(false);
}

Result<pipeline::What> StageOptions::what(bool needs_bin) const {
  Node root = Node::map();
  document::Problems problems("command line");
  if (!units_.empty()) root.set("units", value_of(units_));
  for (const auto& row : given_) {
    if (row->text.empty()) continue;
    Node* section = &root;
    if (!row->key.section.empty()) {
      section = root.find(row->key.section);
      if (!section) section = &root.set(row->key.section, Node::map());
    }
    section->set(row->key.field->name, value_of(row->text));
  }
  if (!seeds_.empty()) {
    Node points = Node::sequence();
    for (const std::string& seed : seeds_) {
      Node point = value_of("[" + seed + "]");
      for (Node& number : point.is_sequence() ? point.items() : Node::Sequence{}) number.mark = {};
      points.push(std::move(point));
    }
    Node* section = root.find("seeds");
    if (!section) section = &root.set("seeds", Node::map());
    section->set("points", std::move(points));
  }
  TRY_ASSIGN(pipeline::What what, pipeline::what_from(root, "command line", needs_bin));
  Node camera = Node::map();
  if (!intrinsics_.empty()) {
    Node numbers = value_of("[" + intrinsics_ + "]");
    numbers.text.clear();
    camera.set("intrinsics", std::move(numbers));
  }
  if (!depth_scale_.empty()) camera.set("depth_scale", value_of(depth_scale_));
  what.camera = pipeline::read_camera(camera, "", problems);
  if (!problems.empty()) return problems.error();
  return what;
}

}  // namespace scanmill::cli
