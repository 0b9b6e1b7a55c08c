// SPDX-License-Identifier: Apache-2.0
#include "document/read_fields.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "base/text.hpp"

namespace scanmill::document {
namespace {

std::string place_of(const std::string& name, Mark mark) { return mark.line > 0 ? place(name, mark) : "command line"; }

std::string limits_text(const Field& row) {
  if (!std::isfinite(row.minimum) && !std::isfinite(row.maximum)) return "any number";
  return std::string(row.minimum_excluded ? "(" : "[") + number_text(row.minimum) + ", " + number_text(row.maximum) +
         "]";
}

bool is_digits(std::string_view text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
}

bool is_extension(std::string_view key) { return key.substr(0, 2) == "x-"; }

/// One overload per kind of member; returns what is allowed when the value is of another kind, else an empty text.
std::string assign(const Node& value, const Field&, bool& member) {
  if (!value.is_bool()) return "true, false";
  member = value.as_bool();
  return {};
}
std::string assign(const Node& value, const Field& row, double& member) {
  if (!value.is_number()) return "a number in " + limits_text(row);
  member = value.as_number();
  return {};
}
std::string assign(const Node& value, const Field& row, std::optional<double>& member) {
  if (value.is_null() || (value.is_string() && value.as_string() == "off")) {
    member.reset();
    return {};
  }
  if (!value.is_number()) return "a number in " + limits_text(row) + ", off";
  member = value.as_number();
  return {};
}
std::string assign(const Node& value, const Field& row, std::int64_t& member) {
  const bool whole =
      value.is_number() && value.as_number() == std::floor(value.as_number()) && std::abs(value.as_number()) < 0x1p53;
  if (!whole) return "a whole number in " + limits_text(row);
  member = value.is_integer() ? value.as_integer() : static_cast<std::int64_t>(value.as_number());
  return {};
}
std::string assign(const Node& value, const Field& row, std::int32_t& member) {
  const auto word =
      value.is_string() ? std::find(row.words.begin(), row.words.end(), value.as_string()) : row.words.end();
  if (word == row.words.end()) return joined(row.words);
  member = static_cast<std::int32_t>(word - row.words.begin());
  return {};
}

}  // namespace

void Problems::add(Mark mark, const std::string& key, const std::string& sentence) {
  lines_.push_back({mark, place_of(name_, mark) + ": " + (key.empty() ? "" : key + ": ") + sentence});
}

void Problems::add_unknown(const Node::Entry& entry, const std::string& prefix,
                           std::span<const std::string_view> allowed) {
  std::string sentence = "unknown key; allowed " + joined(allowed);
  const std::string_view nearest = nearest_name(entry.key, allowed);
  if (!nearest.empty()) sentence += "; nearest " + std::string(nearest);
  if (is_digits(entry.key)) sentence += "; is it the end of a number? Decimals take a point, not a comma";
  add(entry.mark, prefix.empty() ? entry.key : prefix + "." + entry.key, sentence);
}

std::vector<std::string> Problems::lines() const {
  std::vector<Line> sorted = lines_;
  std::stable_sort(sorted.begin(), sorted.end(), [](const Line& a, const Line& b) {
    return std::tie(a.mark.line, a.mark.column) < std::tie(b.mark.line, b.mark.column);
  });
  std::vector<std::string> texts;
  for (Line& line : sorted) texts.push_back(std::move(line.text));
  return texts;
}

Error Problems::error() const {
  std::string all;
  for (const std::string& line : lines()) all += (all.empty() ? "" : "\n") + line;
  return fail(Code::BadParameter, all);
}

namespace {

/// What fits into a line of a message; a whole file may have been taken for a scalar.
std::string first_words(std::string text) {
  constexpr std::size_t kMost = 60;
  std::size_t end = std::min(text.find('\n'), kMost);
  if (end >= text.size()) return text;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xc0) == 0x80) --end;  // no half a letter
  return text.substr(0, end) + "...";
}

/// What slips a person makes with numbers: a decimal comma, a unit behind.
std::string number_hint(std::string_view word) {
  const std::size_t comma = word.find(',');
  if (comma != std::string_view::npos && is_digits(word.substr(0, comma)) && is_digits(word.substr(comma + 1)))
    return "; decimals take a point: " + std::string(word.substr(0, comma)) + "." + std::string(word.substr(comma + 1));
  const std::size_t end = word.find_first_not_of("0123456789.");
  if (end == std::string_view::npos || end == 0) return {};
  const std::string_view unit = word.substr(std::min(word.find_first_not_of(' ', end), word.size()));
  for (const std::string_view known : {"mm", "um", "cm", "m", "in", "inch", "deg", "s", "h", "min", "bins", "%"})
    if (unit == known)
      return "; the key's name says the unit, give the number alone: " + std::string(word.substr(0, end));
  return {};
}

}  // namespace

std::string shown(const Node& node) {
  if (!node.text.empty() && !node.is_map() && !node.is_sequence()) return first_words(node.text);
  if (node.is_map() || node.is_sequence() || node.is_null()) return node.kind();
  return node.is_string() ? std::string("'").append(first_words(node.as_string())).append("'") : to_json(node);
}

std::string joined(std::span<const std::string_view> words) {
  std::string text;
  for (const std::string_view word : words) text += (text.empty() ? "" : ", ") + std::string(word);
  return text;
}

void read_field(const Node& value, const std::string& key, const Field& row, void* object, Problems& problems) {
  const std::string allowed = std::visit([&](auto access) { return assign(value, row, *access(object)); }, row.member);
  if (!allowed.empty()) {
    std::string sentence = "found " + shown(value) + "; allowed " + allowed;
    const std::string_view nearest = value.is_string() ? nearest_name(value.as_string(), row.words) : "";
    if (!nearest.empty()) sentence += "; nearest " + std::string(nearest);
    if (value.is_string() && row.words.empty()) sentence += number_hint(value.as_string());
    problems.add(value.mark, key, sentence);
    return;
  }
  if (!row.words.empty()) return;
  for (const std::string& problem : problems_of(std::span(&row, 1), object))
    problems.add(value.mark, key, problem.substr(row.name.size() + 2));
}

void read_fields(const Node& section, const std::string& name, std::span<const Field> table, void* object,
                 std::span<const std::string_view> others, Problems& problems) {
  std::vector<std::string_view> allowed;
  for (const Field& row : table) allowed.push_back(row.name);
  allowed.insert(allowed.end(), others.begin(), others.end());
  if (!section.is_map()) {
    problems.add(section.mark, name, "found " + shown(section) + "; allowed a map of " + joined(allowed));
    return;
  }
  for (const Node::Entry& entry : section.entries()) {
    const auto row =
        std::find_if(table.begin(), table.end(), [&](const Field& field) { return field.name == entry.key; });
    if (row != table.end())
      read_field(entry.value, name + "." + entry.key, *row, object, problems);
    else if (std::find(others.begin(), others.end(), entry.key) == others.end() && !is_extension(entry.key))
      problems.add_unknown(entry, name, allowed);
  }
}

Node field_value(const Field& row, const void* object) {
  return std::visit(
      [&](auto access) -> Node {
        const auto& member = *access(const_cast<void*>(object));
        using M = std::remove_cvref_t<decltype(member)>;
        if constexpr (std::is_same_v<M, std::optional<double>>)
          return member ? Node(*member) : Node();
        else if constexpr (std::is_same_v<M, std::int32_t>)
          return Node(row.words[static_cast<std::size_t>(member)]);
        else
          return Node(member);
      },
      row.member);
}

Node fields_to_document(std::span<const Field> table, const void* object) {
  Node map = Node::map();
  for (const Field& row : table) map.set(row.name, field_value(row, object));
  return map;
}

Node field_schema(const Field& row, const void* defaults) {
  Node schema = Node::map();
  std::string help(row.help);
  if (!row.symbol.empty()) help += " (" + std::string(row.symbol) + ")";
  schema.set("description", help);
  auto number = [&](Node target, const char* type) {
    target.set("type", type);
    if (std::isfinite(row.minimum)) target.set(row.minimum_excluded ? "exclusiveMinimum" : "minimum", row.minimum);
    if (std::isfinite(row.maximum)) target.set("maximum", row.maximum);
    return target;
  };
  std::visit(
      [&](auto access) {
        using M = std::remove_cvref_t<decltype(*access(nullptr))>;
        if constexpr (std::is_same_v<M, bool>) {
          schema.set("type", "boolean");
        } else if constexpr (std::is_same_v<M, double>) {
          schema = number(std::move(schema), "number");
        } else if constexpr (std::is_same_v<M, std::int64_t>) {
          schema = number(std::move(schema), "integer");
        } else if constexpr (std::is_same_v<M, std::int32_t>) {
          Node words = Node::sequence();
          for (const std::string_view word : row.words) words.push(word);
          schema.set("enum", std::move(words));
        } else {
          Node off = Node::map();
          Node words = Node::sequence();
          words.push("off");
          words.push(Node());
          off.set("enum", std::move(words));
          Node any = Node::sequence();
          any.push(number(Node::map(), "number"));
          any.push(std::move(off));
          schema.set("anyOf", std::move(any));
        }
      },
      row.member);
  const Node value = field_value(row, defaults);
  if (!value.is_null()) schema.set("default", value);
  return schema;
}

Node fields_schema(std::span<const Field> table, const void* defaults, std::string_view help) {
  Node schema = Node::map();
  schema.set("description", help);
  schema.set("type", "object");
  Node properties = Node::map();
  for (const Field& row : table) properties.set(row.name, field_schema(row, defaults));
  schema.set("properties", std::move(properties));
  Node extensions = Node::map();
  extensions.set("^x-", Node::map());
  schema.set("patternProperties", std::move(extensions));
  schema.set("additionalProperties", false);
  return schema;
}

}  // namespace scanmill::document
