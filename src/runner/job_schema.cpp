// SPDX-License-Identifier: Apache-2.0
// The schema of a job file, from the tables that read it.
#include "runner/job.hpp"

namespace scanmill::runner {
namespace {

using document::Node;

Node described(const char* type, const char* help) {
  Node schema = Node::map();
  schema.set("description", help);
  if (type) schema.set("type", type);
  return schema;
}

/// A map that takes these keys, keys that begin with "x-", and no others.
Node object(Node properties, const char* help) {
  Node schema = document::fields_schema({}, nullptr, help);
  schema.set("properties", std::move(properties));
  return schema;
}

Node scans_schema() {
  Node globs = Node::sequence();
  globs.push(described("string", "A scan name or pattern; * stands for any characters, ? for one."));
  Node list = described("array", "Several of them.");
  list.set("items", globs.items()[0]);
  list.set("minItems", 1);
  globs.push(std::move(list));
  Node scans = described(nullptr, "Which scans.");
  scans.set("anyOf", std::move(globs));
  return scans;
}

/// A text of this form, or a number of what it counts.
Node text_or_number(const char* pattern, const char* number, const char* help) {
  Node text = Node::map();
  text.set("type", "string");
  text.set("pattern", pattern);
  Node plain = Node::map();
  plain.set("type", number);
  plain.set("minimum", 1);
  Node either = Node::sequence();
  either.push(std::move(text));
  either.push(std::move(plain));
  Node schema = described(nullptr, help);
  schema.set("anyOf", std::move(either));
  return schema;
}

Node resources_schema() {
  How defaults;
  defaults.threads = 1;
  Node resources =
      document::fields_schema(resource_fields(), &defaults, "What a run may use; changes no byte of the result.");
  Node& keys = *resources.find("properties");
  std::erase_if(keys.find("threads")->entries(), [](const Node::Entry& e) { return e.key == "default"; });
  const char* size = "^[0-9.]+([KMGT](i?B)?|B)?$";
  keys.set("memory",
           text_or_number(size, "integer", "Memory cap, such as 512M or 2G; without the key 80 % of the machine's."));
  keys.set("disk", text_or_number(size, "integer",
                                  "Disk space the run may use, such as 50G; without the key 80 % of what is free."));
  keys.set("scan_time_limit", text_or_number("^[0-9.]+ *[smhd]?$", "number",
                                             "A scan that takes longer is stopped, such as 90m; 6h by "
                                             "default."));
  Node until = described("string", "Time of day, such as 05:30; no scan is started that would not end by then.");
  until.set("pattern", "^[0-9]{1,2}:[0-9]{2}$");
  keys.set("until", std::move(until));
  return resources;
}

}  // namespace

Node job_schema(const Node& what_properties) {
  Node properties = Node::map();
  Node one = described(nullptr, "Version of this format.");
  one.set("const", 1);
  properties.set("scanmill", std::move(one));
  properties.set(
      "archive",
      described("string", "Folder with the scans, relative to the job file; without the key the job file's folder."));
  const Node scans = scans_schema();
  properties.set("scans", scans);
  Node over = Node::map();
  over.set("scans", scans);
  for (const Node::Entry& entry : what_properties.entries()) {
    properties.set(entry.key, entry.value);
    if (!is_whole_archive_key(entry.key)) over.set(entry.key, entry.value);
  }
  Node item = object(std::move(over), "Keys for some scans.");
  Node required = Node::sequence();
  required.push("scans");
  item.set("required", std::move(required));
  Node overrides = described("array", "What keys for some scans; later entries win.");
  overrides.set("items", std::move(item));
  properties.set("overrides", std::move(overrides));

  properties.set("resources", resources_schema());
  Node executor = described(nullptr, "How tasks are run.");
  Node executors = Node::sequence();
  for (const std::string_view word : executor_words()) executors.push(word);
  executor.set("enum", std::move(executors));
  properties.set("executor", std::move(executor));
  Node strict = described("boolean", "Scans that an earlier run quarantined make this run fail too.");
  strict.set("default", false);
  properties.set("strict", std::move(strict));
  const How defaults;
  properties.set("settle_s", document::field_schema(settle_field(), &defaults));
  properties.set("retry",
                 document::fields_schema(retry_fields(), &defaults, "How often failed scans are tried again."));
  properties.set("notify", notify_schema());
  properties.set("cluster", cluster_schema());
  const BrickKeys bricks;
  Node brick = document::fields_schema(brick_fields(), &bricks,
                                       "How a large scan is cut into tasks; changes no byte of the result.");
  Node edge = described(nullptr, "Edge of a brick of the lattice in bins; a number has every scan cut that can be.");
  Node edges = Node::sequence();
  edges.push("auto");
  for (const int bins : {8, 16, 32, 64, 128, 256}) edges.push(bins);
  edge.set("enum", std::move(edges));
  edge.set("default", "auto");
  brick.find("properties")->set("edge_bins", std::move(edge));
  properties.set("brick", std::move(brick));

  Node schema = Node::map();
  schema.set("$schema", "http://json-schema.org/draft-07/schema#");
  schema.set("title", "scanmill job");
  Node body = object(std::move(properties), "A job file of scanmill.");
  for (Node::Entry& entry : body.entries()) schema.set(entry.key, std::move(entry.value));
  Node top = Node::sequence();
  top.push("scanmill");
  schema.set("required", std::move(top));
  return schema;
}

}  // namespace scanmill::runner
