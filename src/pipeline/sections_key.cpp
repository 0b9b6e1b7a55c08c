// SPDX-License-Identifier: Apache-2.0
#include "pipeline/sections_key.hpp"

#include <algorithm>
#include <optional>

#include "base/text.hpp"
#include "pipeline/tool_inputs.hpp"
#include "verify/sections.hpp"

namespace scanmill::pipeline {
namespace {

using document::Node;
using document::Problems;
using document::shown;
using verify::SectionRule;
using Where = verify::SectionRule::Where;

constexpr std::string_view kRuleKeys[] = {"axis", "at_mm", "count", "through", "slab_mm", "magnify", "name"};
constexpr std::string_view kAxes[] = {"x", "y", "z"};
constexpr std::string_view kFeatures[] = {"worst", "loop"};
constexpr Vec3 kDirections[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

std::optional<Vec3> triple_of(const Node& value) {
  const bool numbers =
      value.is_sequence() && value.items().size() == 3 &&
      std::all_of(value.items().begin(), value.items().end(), [](const Node& n) { return n.is_number(); });
  if (!numbers) return std::nullopt;
  const Vec3 triple{value.items()[0].as_number(), value.items()[1].as_number(), value.items()[2].as_number()};
  return is_finite(triple) ? std::optional(triple) : std::nullopt;
}

void read_axis(const Node& value, const std::string& key, SectionRule& rule, Problems& problems) {
  for (std::size_t n = 0; n < 3; ++n)
    if (value.is_string() && value.as_string() == kAxes[n]) {
      rule.axis = kDirections[n];
      return;
    }
  if (const auto direction = triple_of(value); direction && norm2(*direction) > 0) {
    rule.axis = *direction;
    return;
  }
  problems.add(value.mark, key, "found " + shown(value) + "; allowed x, y, z, a direction [x, y, z]");
}

void read_through(const Node& value, const std::string& key, SectionRule& rule, Problems& problems) {
  if (value.is_string() && value.as_string() == "worst") {
    rule.where = Where::Worst;
  } else if (value.is_string() && value.as_string() == "loop") {
    rule.where = Where::Loop;
  } else if (const auto point = triple_of(value)) {
    rule.where = Where::Point;
    rule.point = *point;
  } else {
    std::string sentence = "found " + shown(value) + "; allowed worst, loop, a point [x, y, z] in mm";
    const std::string_view nearest = value.is_string() ? nearest_name(value.as_string(), kFeatures) : "";
    if (!nearest.empty()) sentence += "; nearest " + std::string(nearest);
    problems.add(value.mark, key, sentence);
  }
}

bool is_number_in(const Node& value, double low, double high) {
  return value.is_number() && value.as_number() >= low && value.as_number() <= high;
}

SectionRule read_rule(const Node& item, const std::string& key, Problems& problems) {
  SectionRule rule;
  document::read_fields(item, key, {}, nullptr, kRuleKeys, problems);
  if (!item.is_map()) return rule;
  if (const Node* axis = item.find("axis"))
    read_axis(*axis, key + ".axis", rule, problems);
  else
    problems.add(item.mark, key, "found no axis; wanted axis: x, y, z or a direction [x, y, z]");
  int places = 0;
  if (const Node* at = item.find("at_mm")) {
    ++places;
    rule.where = Where::At;
    if (is_number_in(*at, -1e9, 1e9))
      rule.at_mm = at->as_number();
    else
      problems.add(at->mark, key + ".at_mm", "found " + shown(*at) + "; allowed [-1e9, 1e9]");
  }
  if (const Node* count = item.find("count")) {
    ++places;
    rule.where = Where::Count;
    if (is_number_in(*count, 1, verify::kMostSections) &&
        static_cast<double>(static_cast<std::int64_t>(count->as_number())) == count->as_number())
      rule.count = static_cast<std::int64_t>(count->as_number());
    else
      problems.add(count->mark, key + ".count", "found " + shown(*count) + "; allowed whole numbers in [1, 100]");
  }
  if (const Node* through = item.find("through")) {
    ++places;
    read_through(*through, key + ".through", rule, problems);
  }
  if (places != 1)
    problems.add(item.mark, key,
                 std::string(places == 0 ? "found no place" : "found more than one place") +
                     "; wanted one of at_mm: 12.5, count: 3, through: worst, through: loop, through: [x, y, z]");
  auto positive = [&](const char* name, std::optional<double>& target) {
    const Node* value = item.find(name);
    if (!value) return;
    if (is_number_in(*value, 1e-9, 1e9))
      target = value->as_number();
    else
      problems.add(value->mark, key + "." + name, "found " + shown(*value) + "; allowed [1e-9, 1e9]");
  };
  positive("slab_mm", rule.slab_mm);
  positive("magnify", rule.magnify);
  if (const Node* name = item.find("name")) {
    if (name->is_string())
      rule.name = name->as_string();
    else
      problems.add(name->mark, key + ".name", "found " + shown(*name) + "; allowed a text");
  }
  return rule;
}

Node number_schema(const char* help, const char* type = "number") {
  Node schema = Node::map();
  schema.set("description", help);
  schema.set("type", type);
  return schema;
}

Node words_or_triple(std::span<const std::string_view> words, const char* help) {
  Node list = Node::sequence();
  for (const std::string_view word : words) list.push(word);
  Node choice = Node::map();
  choice.set("enum", std::move(list));
  Node number = Node::map();
  number.set("type", "number");
  Node three = Node::map();
  three.set("type", "array");
  three.set("items", std::move(number));
  three.set("minItems", 3);
  three.set("maxItems", 3);
  Node choices = Node::sequence();
  choices.push(std::move(choice));
  choices.push(std::move(three));
  Node schema = Node::map();
  schema.set("description", help);
  schema.set("anyOf", std::move(choices));
  return schema;
}

}  // namespace

std::vector<SectionRule> read_sections(const Node& value, Problems& problems) {
  std::vector<SectionRule> rules;
  if (value.is_null() || (value.is_string() && value.as_string() == "off")) return rules;
  if (value.is_map()) {
    rules.push_back(read_rule(value, "verify.sections", problems));
  } else if (value.is_sequence()) {
    for (std::size_t n = 0; n < value.items().size(); ++n)
      rules.push_back(read_rule(value.items()[n], "verify.sections[" + std::to_string(n) + "]", problems));
  } else {
    problems.add(value.mark, "verify.sections",
                 "found " + shown(value) + "; allowed a list such as [{axis: z, count: 3}, {axis: x, through: worst}]");
  }
  std::int64_t planes = 0;
  for (const SectionRule& rule : rules) planes += rule.where == Where::Count ? rule.count : 1;
  if (planes > static_cast<std::int64_t>(verify::kMostSections))
    problems.add(value.mark, "verify.sections",
                 "found " + std::to_string(planes) + " planes; allowed " + std::to_string(verify::kMostSections));
  return rules;
}

namespace {

/// "a,b,c" as a list, numbers as numbers, anything else as a text.
Node value_of(std::string_view text) {
  if (const auto number = parse_number(text)) return Node(*number);
  if (text.find(',') == std::string_view::npos) return Node(std::string(text));
  Node list = Node::sequence();
  for (std::size_t at = 0; at <= text.size();) {
    const std::size_t end = std::min(text.find(',', at), text.size());
    list.push(value_of(text.substr(at, end - at)));
    at = end + 1;
  }
  return list;
}

Result<Node> rule_of(const std::string& word) {
  if (word.starts_with('{')) return document::parse_yaml(word, "command line: --section");
  const std::size_t sign = word.find('=');
  if (sign == std::string::npos || sign == 0 || sign + 1 == word.size())
    return fail(Code::BadParameter,
                "--section: found " + word +
                    "; wanted AXIS=PLACE such as z=12.5, x=worst, y=loop, z=3x, 1,1,0=5, or a map as in the job",
                "command line");
  const std::string_view place = std::string_view(word).substr(sign + 1);
  Node rule = Node::map();
  rule.set("axis", value_of(std::string_view(word).substr(0, sign)));
  const auto count = place.ends_with('x') ? parse_number(place.substr(0, place.size() - 1)) : std::nullopt;
  const auto at = parse_number(place);
  if (count)
    rule.set("count", *count);
  else if (at)
    rule.set("at_mm", *at);
  else
    rule.set("through", value_of(place));
  return rule;
}

}  // namespace

Result<std::vector<SectionRule>> sections_from_words(const std::vector<std::string>& words) {
  Node list = Node::sequence();
  for (const std::string& word : words) {
    TRY_ASSIGN(Node rule, rule_of(word));
    list.push(std::move(rule));
  }
  Problems problems("command line");
  std::vector<SectionRule> rules = read_sections(list, problems);
  if (!problems.empty()) return problems.error();
  return rules;
}

Node sections_to_document(const std::vector<SectionRule>& rules) {
  Node list = Node::sequence();
  for (const SectionRule& rule : rules) {
    Node item = Node::map();
    const auto axis = std::find(std::begin(kDirections), std::end(kDirections), rule.axis);
    if (axis != std::end(kDirections))
      item.set("axis", kAxes[axis - std::begin(kDirections)]);
    else
      item.set("axis", triple(rule.axis));
    switch (rule.where) {
      case Where::At:
        item.set("at_mm", rule.at_mm);
        break;
      case Where::Count:
        item.set("count", rule.count);
        break;
      case Where::Point:
        item.set("through", triple(rule.point));
        break;
      case Where::Worst:
      case Where::Loop:
        item.set("through", rule.where == Where::Worst ? "worst" : "loop");
    }
    if (rule.slab_mm) item.set("slab_mm", *rule.slab_mm);
    if (rule.magnify) item.set("magnify", *rule.magnify);
    if (!rule.name.empty()) item.set("name", rule.name);
    list.push(std::move(item));
  }
  return list;
}

Node sections_schema() {
  Node item = Node::map();
  item.set("type", "object");
  Node& keys = item.set("properties", Node::map());
  keys.set("axis", words_or_triple(kAxes, "What the planes are at right angles to."));
  keys.set("at_mm", number_schema("Distance of the plane from the origin of the global frame, along the axis, mm."));
  Node count = number_schema("That many planes, spread evenly through the mesh.", "integer");
  count.set("minimum", 1);
  count.set("maximum", static_cast<std::int64_t>(verify::kMostSections));
  keys.set("count", std::move(count));
  keys.set("through",
           words_or_triple(kFeatures, "The point farthest from the mesh, the longest open loop, or a point, mm."));
  for (const auto& [name, help] :
       {std::pair("slab_mm", "Thickness of the slab of points, mm; the bin edge when not given."),
        std::pair("magnify", "Of deviations in drawings; chosen by the size of the section when not given.")}) {
    Node number = number_schema(help);
    number.set("exclusiveMinimum", 0);
    keys.set(name, std::move(number));
  }
  keys.set("name", number_schema("Of the section in drawings.", "string"));
  Node required = Node::sequence();
  required.push("axis");
  item.set("required", std::move(required));
  item.set("additionalProperties", false);
  Node list = Node::map();
  list.set("type", "array");
  list.set("items", item);
  Node off = Node::map();
  off.set("const", "off");
  Node choices = Node::sequence();
  choices.push(std::move(list));
  choices.push(std::move(item));
  choices.push(std::move(off));
  Node schema = Node::map();
  schema.set("description",
             "Planes to cut the mesh with; the measured points beside them are drawn with their deviations.");
  schema.set("anyOf", std::move(choices));
  return schema;
}

}  // namespace scanmill::pipeline
