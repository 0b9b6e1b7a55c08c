// SPDX-License-Identifier: Apache-2.0
// The wall around nlohmann-json: reading only; writing is a page of our own in document.cpp.
#include <nlohmann/json.hpp>

#include "document/document.hpp"

namespace scanmill::document {
namespace {

Node convert(const nlohmann::ordered_json& json) {
  if (json.is_boolean()) return Node(json.get<bool>());
  if (json.is_number_integer()) return Node(json.get<std::int64_t>());
  if (json.is_number()) return Node(json.get<double>());
  if (json.is_string()) return Node(json.get<std::string>());
  if (json.is_array()) {
    Node node = Node::sequence();
    for (const auto& item : json) node.push(convert(item));
    return node;
  }
  if (json.is_object()) {
    Node node = Node::map();
    for (const auto& [key, value] : json.items()) node.set(key, convert(value));
    return node;
  }
  return {};
}

}  // namespace

Result<Node> parse_json(std::string_view text, const std::string& name) {
  try {
    return convert(nlohmann::ordered_json::parse(text.begin(), text.end()));
  } catch (const nlohmann::json::exception& error) {
    return fail(Code::BadParameter, std::string("not readable as JSON: ") + error.what(), name);
  }
}

}  // namespace scanmill::document
