// SPDX-License-Identifier: Apache-2.0
#include "pipeline/outputs_key.hpp"

#include <algorithm>

#include "base/text.hpp"
#include "export/dxf.hpp"
#include "export/iges.hpp"

namespace scanmill::pipeline {
namespace {

using document::Node;
using document::Problems;
using document::shown;

constexpr std::string_view kFormats[] = {"stl", "ply", "obj", "iges", "dxf", "3mf", "vdb"};
constexpr std::string_view kSuffixes[] = {"stl", "ply", "obj", "igs", "iges", "dxf", "3mf"};

bool among(std::span<const std::string_view> words, std::string_view word) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

constexpr std::string_view kTolerance = "tolerance_bins";
constexpr double kLeastTolerance = 0.001, kMostTolerance = 10;

/// The options of a format.
std::vector<std::string_view> options_of(std::string_view format) {
  if (format == "stl") return {"ascii"};
  if (format == "iges") return {"style", kTolerance};
  return styles_of(format).empty() ? std::vector<std::string_view>() : std::vector<std::string_view>{"style"};
}

void read_tolerance(const Node& value, Output& output, Problems& problems) {
  if (value.is_number() && value.as_number() >= kLeastTolerance && value.as_number() <= kMostTolerance)
    output.tolerance_bins = value.as_number();
  else
    problems.add(value.mark, "outputs.iges." + std::string(kTolerance),
                 "found " + shown(value) + "; allowed " + number_text(kLeastTolerance) + " to " +
                     number_text(kMostTolerance) + " bin edges");
}

void read_style(const Node& value, const std::string& key, Output& output, Problems& problems) {
  const auto styles = styles_of(output.format);
  if (value.is_string() && among(styles, value.as_string())) {
    output.style = value.as_string();
    return;
  }
  std::string sentence = "found " + shown(value) + "; allowed " + document::joined(styles);
  const std::string_view nearest = value.is_string() ? nearest_name(value.as_string(), styles) : "";
  if (!nearest.empty()) sentence += "; nearest " + std::string(nearest);
  problems.add(value.mark, key, sentence);
}

void read_options(const Node& options, Output& output, Problems& problems) {
  const std::vector<std::string_view> known = options_of(output.format);
  const std::string key = "outputs." + output.format;
  if (known.empty())
    return problems.add(options.mark, "outputs",
                        "found options for " + output.format + "; it takes none: write - " + output.format);
  if (!options.is_map())
    return problems.add(
        options.mark, key,
        "found " + shown(options) + "; allowed {" +
            (known[0] == "ascii" ? std::string("ascii: true") : "style: " + std::string(styles_of(output.format)[0])) +
            "}");
  const Node* tolerance = nullptr;
  for (const Node::Entry& entry : options.entries()) {
    if (std::find(known.begin(), known.end(), entry.key) == known.end())
      problems.add_unknown(entry, key, known);
    else if (entry.key == "style")
      read_style(entry.value, key + ".style", output, problems);
    else if (entry.key == kTolerance)
      read_tolerance(*(tolerance = &entry.value), output, problems);
    else if (!entry.value.is_bool())
      problems.add(entry.value.mark, key + ".ascii", "found " + shown(entry.value) + "; allowed true, false");
    else
      output.ascii = entry.value.as_bool();
  }
  if (tolerance && output.style != "surfaces")
    problems.add(
        tolerance->mark, key + "." + std::string(kTolerance),
        "is of style surfaces only; found style " + output.style + ": remove the key, or write style: surfaces");
}

void read_output(const Node& item, std::vector<Output>& outputs, Problems& problems) {
  const bool with_options = item.is_map() && item.entries().size() == 1;
  Output output;
  output.format = with_options ? item.entries()[0].key : item.is_string() ? item.as_string() : "";
  const std::string allowed = "; allowed " + document::joined(kFormats);
  if (!among(kFormats, output.format)) {
    std::string sentence = "found " + shown(item) + allowed;
    const std::string_view nearest = nearest_name(output.format, kFormats);
    if (!nearest.empty()) sentence += "; nearest " + std::string(nearest);
    return problems.add(item.mark, "outputs", sentence);
  }
  if (const auto styles = styles_of(output.format); !styles.empty()) output.style = styles[0];
  if (with_options) read_options(item.entries()[0].value, output, problems);
  if (std::any_of(outputs.begin(), outputs.end(),
                  [&](const Output& present) { return present.format == output.format; }))
    return problems.add(item.mark, "outputs", output.format + " is asked for twice; remove one");
  outputs.push_back(output);
}

Node style_schema(std::string_view format) {
  Node words = Node::sequence();
  for (const std::string_view style : styles_of(format)) words.push(style);
  Node schema = Node::map();
  schema.set("enum", std::move(words));
  schema.set("default", styles_of(format)[0]);
  return schema;
}

Node ascii_schema() {
  Node schema = Node::map();
  schema.set("description", "As text, ten times as large.");
  schema.set("type", "boolean");
  return schema;
}

Node tolerance_schema() {
  Node schema = Node::map();
  schema.set("description",
             "Style surfaces: greatest distance of a point of the cloud from its surface, in bin edges; triangles "
             "where it does not hold are written as facets.");
  schema.set("type", "number");
  schema.set("minimum", kLeastTolerance);
  schema.set("maximum", kMostTolerance);
  schema.set("default", kSurfaceTolerance);
  return schema;
}

}  // namespace

std::span<const std::string_view> output_words() { return kFormats; }
std::span<const std::string_view> mesh_suffixes() { return kSuffixes; }

std::span<const std::string_view> styles_of(std::string_view format) {
  if (format == "iges") return exporting::iges_style_words();
  if (format == "dxf") return exporting::dxf_style_words();
  return {};
}

std::string file_name_of(const Output& output) {
  if (output.format == "vdb") return "bins.vdb";
  return "mesh." + (output.format == "iges" ? "igs" : output.format);
}

std::string_view format_of_suffix(std::string_view suffix) {
  if (suffix == "igs") return "iges";
  const auto at = std::find(std::begin(kFormats), std::end(kFormats), suffix);
  return at == std::end(kFormats) || !among(kSuffixes, suffix) ? "" : *at;
}

std::vector<Output> read_outputs(const Node& value, Problems& problems) {
  std::vector<Output> outputs;
  if (!value.is_sequence() || value.items().empty())
    problems.add(value.mark, "outputs",
                 "found " + (value.is_sequence() ? "an empty list" : shown(value)) + "; allowed a list of " +
                     document::joined(kFormats));
  else
    for (const Node& item : value.items()) read_output(item, outputs, problems);
  return outputs;
}

Node outputs_to_document(const std::vector<Output>& outputs) {
  Node list = Node::sequence();
  for (const Output& output : outputs) {
    if (!output.ascii && output.style.empty()) {
      list.push(output.format);
      continue;
    }
    Node options = Node::map();
    if (output.ascii) options.set("ascii", true);
    if (!output.style.empty()) options.set("style", output.style);
    if (output.style == "surfaces") options.set(std::string(kTolerance), output.tolerance_bins);
    Node entry = Node::map();
    entry.set(output.format, std::move(options));
    list.push(std::move(entry));
  }
  return list;
}

Node outputs_schema() {
  Node words = Node::sequence();
  for (const std::string_view word : output_words()) words.push(word);
  Node item = Node::map();
  item.set("enum", std::move(words));
  Node with_options = Node::map();
  with_options.set("type", "object");
  Node& formats = with_options.set("properties", Node::map());
  for (const std::string_view format : output_words()) {
    const std::vector<std::string_view> known = options_of(format);
    if (known.empty()) continue;
    Node options = Node::map();
    options.set("type", "object");
    Node& properties = options.set("properties", Node::map());
    for (const std::string_view option : known)
      properties.set(std::string(option), option == "ascii"      ? ascii_schema()
                                          : option == kTolerance ? tolerance_schema()
                                                                 : style_schema(format));
    options.set("additionalProperties", false);
    formats.set(format, std::move(options));
  }
  with_options.set("additionalProperties", false);
  with_options.set("minProperties", 1);
  Node choices = Node::sequence();
  choices.push(std::move(item));
  choices.push(std::move(with_options));
  Node items = Node::map();
  items.set("anyOf", std::move(choices));
  Node schema = Node::map();
  schema.set("description", "Files to write beside record, report and pictures; an entry may carry options.");
  schema.set("type", "array");
  schema.set("items", std::move(items));
  schema.set("minItems", 1);
  schema.set("uniqueItems", true);
  return schema;
}

std::span<const std::string_view> preview_words() {
  static constexpr std::string_view kWords[] = {"shaded", "error", "patches"};
  return kWords;
}

std::vector<std::string> read_previews(const Node& value, Problems& problems) {
  const auto words = preview_words();
  const std::string allowed = "; allowed a list of " + document::joined(words) + ", one at least";
  if (!value.is_sequence() || value.items().empty())
    return problems.add(value.mark, "previews",
                        "found " + (value.is_sequence() ? "an empty list" : shown(value)) + allowed),
           std::vector<std::string>{};
  std::vector<bool> asked(words.size(), false);
  for (const Node& item : value.items()) {
    const auto at = item.is_string() ? std::find(words.begin(), words.end(), item.as_string()) : words.end();
    if (at == words.end())
      problems.add(item.mark, "previews", "found " + shown(item) + allowed);
    else
      asked[static_cast<std::size_t>(at - words.begin())] = true;
  }
  std::vector<std::string> list;
  for (std::size_t n = 0; n < words.size(); ++n)
    if (asked[n]) list.emplace_back(words[n]);
  return list;
}

Node previews_schema() {
  Node all = Node::sequence();
  for (const std::string_view word : preview_words()) all.push(word);
  Node item = Node::map();
  item.set("enum", all);
  Node schema = Node::map();
  schema.set("description",
             "Pictures of the report, preview-WORD.png; each costs about a fifth of a small scan's time.");
  schema.set("type", "array");
  schema.set("items", std::move(item));
  schema.set("minItems", 1);
  schema.set("default", std::move(all));
  return schema;
}

}  // namespace scanmill::pipeline
