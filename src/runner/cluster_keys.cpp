// SPDX-License-Identifier: Apache-2.0
#include "runner/cluster_keys.hpp"

#include "base/text.hpp"
#include "runner/job.hpp"

namespace scanmill::runner {

using document::Node;
using document::shown;

namespace {

constexpr std::string_view kTextKeys[] = {"partition", "account", "qos",  "program",
                                          "extra",     "wrap",    "time", "element_time"};

std::span<const Field> fields() {
  static const Field kTable[] = {
      field<ClusterKeys, &ClusterKeys::chunk>("chunk", "", "Elements of a job array at most.", {1, 100000}),
      field<ClusterKeys, &ClusterKeys::scans_per_element>(
          "scans_per_element", "", "Scans of an element; 0: by the forecast, so that it runs for element_time.",
          {0, 100000}),
      field<ClusterKeys, &ClusterKeys::spread>("spread", "", "Elements at least, as far as there are scans.",
                                               {1, 100000}),
      field<ClusterKeys, &ClusterKeys::poll_s>("poll_s", "", "Between two looks at the queue.", {0.05, 600}),
      field<ClusterKeys, &ClusterKeys::lease_s>(
          "lease_s", "", "An element that Slurm does not know and that shows no life for so long is lost.", {1, 86400}),
      field<ClusterKeys, &ClusterKeys::resubmits>(
          "resubmits", "", "How often a scan is submitted again after its node was lost.", {0, 1000}),
  };
  return kTable;
}

struct TextKey {
  const char* name;
  std::string ClusterKeys::*member;
  const char* help;
};
constexpr TextKey kTexts[] = {
    {"partition", &ClusterKeys::partition, "Partition; the cluster's default unless given."},
    {"account", &ClusterKeys::account, "Account to charge."},
    {"qos", &ClusterKeys::qos, "Quality of service."},
    {"program", &ClusterKeys::program, "scanmill as the nodes find it; the path of the one that submits unless given."},
};

/// A text or number as it was written, without control bytes.
bool read_word(const Node& value, std::string& to) {
  const std::string word = value.is_string() ? value.as_string() : value.is_number() ? value.text : "";
  for (const char c : word)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) return false;
  if (word.empty()) return false;
  to = word;
  return true;
}

void read_words(const Node& value, const std::string& key, std::vector<std::string>& to, const char* allowed,
                document::Problems& problems) {
  std::string word;
  if (!value.is_sequence()) {
    if (!read_word(value, word)) return problems.add(value.mark, key, "found " + shown(value) + "; allowed " + allowed);
    for (const std::string_view part : words_of(word)) to.emplace_back(part);
    return;
  }
  for (const Node& item : value.items())
    if (read_word(item, word))
      to.push_back(word);
    else
      problems.add(item.mark, key, "found " + shown(item) + "; allowed " + allowed);
}

void read_time(const Node& section, const char* key, double& to, document::Problems& problems) {
  const Node* value = section.find(key);
  if (!value) return;
  const auto seconds = parse_duration(value->is_string() ? value->as_string() : value->text);
  if (seconds)
    to = *seconds;
  else
    problems.add(value->mark, std::string("cluster.") + key, "found " + shown(*value) + "; allowed a time such as 30m");
}

Node described(const char* type, const char* help) {
  Node schema = Node::map();
  schema.set("description", help);
  schema.set("type", type);
  return schema;
}

Node words_schema(const char* help) {
  Node either = Node::sequence();
  Node text = described("string", "Words between blanks.");
  text.set("minLength", 1);
  Node list = described("array", "Words as they are.");
  Node item = Node::map();
  item.set("type", "string");
  item.set("minLength", 1);
  list.set("items", std::move(item));
  either.push(std::move(text));
  either.push(std::move(list));
  Node schema = Node::map();
  schema.set("description", help);
  schema.set("anyOf", std::move(either));
  return schema;
}

Node time_schema(const char* help) {
  Node either = Node::sequence();
  Node text = Node::map();
  text.set("type", "string");
  text.set("pattern", "^[0-9.]+ *[smhd]?$");
  Node number = Node::map();
  number.set("type", "number");
  number.set("minimum", 1);
  either.push(std::move(text));
  either.push(std::move(number));
  Node schema = Node::map();
  schema.set("description", help);
  schema.set("anyOf", std::move(either));
  return schema;
}

}  // namespace

void read_cluster(const Node& section, ClusterKeys& keys, document::Problems& problems) {
  document::read_fields(section, "cluster", fields(), &keys, kTextKeys, problems);
  if (!section.is_map()) return;
  for (const TextKey& text : kTexts)
    if (const Node* value = section.find(text.name); value && !read_word(*value, keys.*text.member))
      problems.add(value->mark, std::string("cluster.") + text.name, "found " + shown(*value) + "; allowed a word");
  if (const Node* extra = section.find("extra"))
    read_words(*extra, "cluster.extra", keys.extra, "options of sbatch such as --constraint=avx512", problems);
  if (const Node* wrap = section.find("wrap"))
    read_words(*wrap, "cluster.wrap", keys.wrap, "the words of a command such as apptainer exec scanmill.sif",
               problems);
  read_time(section, "time", keys.time_s, problems);
  read_time(section, "element_time", keys.element_s, problems);
}

Node cluster_schema() {
  const ClusterKeys defaults;
  Node schema =
      document::fields_schema(fields(), &defaults, "How work is handed to Slurm; changes no byte of a result.");
  Node& properties = *schema.find("properties");
  for (const TextKey& text : kTexts) {
    Node one = Node::map();
    one.set("description", text.help);
    Node types = Node::sequence();
    types.push("string");
    types.push("number");
    one.set("type", std::move(types));
    properties.set(text.name, std::move(one));
  }
  properties.set("extra", words_schema("Further options of sbatch."));
  properties.set("wrap", words_schema("Command in front of scanmill on a node: a container, an environment."));
  properties.set("time", time_schema("Time limit of an element; by the forecast unless given."));
  Node element = time_schema("An element is meant to run for so long: scans are put together by the forecast.");
  element.set("default", "5m");
  properties.set("element_time", std::move(element));
  return schema;
}

}  // namespace scanmill::runner
