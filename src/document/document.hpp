// SPDX-License-Identifier: Apache-2.0
// A document tree with marks: what YAML and JSON files become, and what JSON output is made from.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "base/result.hpp"

namespace scanmill::document {

/// Place in the text, both from 1; 0 when the node was not read from a text.
struct Mark {
  int line = 0;
  int column = 0;
};

/// A value with its place. Maps keep their order and hold each key once.
class Node {
 public:
  struct Entry;
  using Sequence = std::vector<Node>;
  using Map = std::vector<Entry>;

  Node() = default;
  Node(bool value) : value_(value) {}                                      // NOLINT: by intent
  Node(std::int64_t value) : value_(value) {}                              // NOLINT: by intent
  Node(int value) : value_(static_cast<std::int64_t>(value)) {}            // NOLINT: by intent
  Node(std::uint64_t value) : value_(static_cast<std::int64_t>(value)) {}  // NOLINT: by intent
  Node(std::uint32_t value) : value_(static_cast<std::int64_t>(value)) {}  // NOLINT: by intent
  Node(double value) : value_(value) {}                                    // NOLINT: by intent
  Node(std::string value) : value_(std::move(value)) {}                    // NOLINT: by intent
  Node(std::string_view value) : value_(std::string(value)) {}             // NOLINT: by intent
  Node(const char* value) : value_(std::string(value)) {}                  // NOLINT: by intent
  static Node sequence() {
    Node node;
    node.value_ = Sequence{};
    return node;
  }
  static Node map() {
    Node node;
    node.value_ = Map{};
    return node;
  }

  bool is_null() const { return value_.index() == 0; }
  bool is_bool() const { return value_.index() == 1; }
  bool is_integer() const { return value_.index() == 2; }
  bool is_number() const { return value_.index() == 2 || value_.index() == 3; }
  bool is_string() const { return value_.index() == 4; }
  bool is_sequence() const { return value_.index() == 5; }
  bool is_map() const { return value_.index() == 6; }
  const char* kind() const;

  bool as_bool() const { return std::get<bool>(value_); }
  std::int64_t as_integer() const { return std::get<std::int64_t>(value_); }
  double as_number() const {
    return is_integer() ? static_cast<double>(std::get<std::int64_t>(value_)) : std::get<double>(value_);
  }
  const std::string& as_string() const { return std::get<std::string>(value_); }
  const Sequence& items() const { return std::get<Sequence>(value_); }
  Sequence& items() { return std::get<Sequence>(value_); }
  const Map& entries() const { return std::get<Map>(value_); }
  Map& entries() { return std::get<Map>(value_); }

  /// The value under `key`, or nullptr; also nullptr when this is no map.
  const Node* find(std::string_view key) const;
  Node* find(std::string_view key);
  /// Replaces or appends.
  Node& set(std::string_view key, Node value);
  /// Appends to a sequence.
  void push(Node value) { items().push_back(std::move(value)); }

  Mark mark;         // of the value
  std::string text;  // a scalar exactly as written, unquoted; empty for nodes that were not read from a text

 private:
  std::variant<std::monostate, bool, std::int64_t, double, std::string, Sequence, Map> value_;
};

struct Node::Entry {
  std::string key;
  Mark mark;  // of the key
  Node value;
};

/// YAML 1.1 text, restricted: one document; no aliases, anchors or tags; plain scalars are null/~, true/false, numbers
/// by from_chars, else strings (so 010 is a string's worth of trouble less: it reads as 10); duplicate keys refused.
/// JSON is a subset. Limits: depth 64, 1,000,000 nodes.
/// errors  BadParameter with "name:line:column" as place
Result<Node> parse_yaml(std::string_view text, const std::string& name);
/// Strict JSON; the same limits, no marks (and `name` alone as place).
Result<Node> parse_json(std::string_view text, const std::string& name);

/// JSON text; bytes that are no UTF-8 become \xNN (as text). `indent` < 0 gives one line. Numbers in their shortest
/// round-trip form; maps in their own order.
std::string to_json(const Node& node, int indent = -1);
/// JSON with keys in byte order, no spaces: the same value gives the same bytes. 1.0 and 1 both print as 1.
std::string to_canonical_json(const Node& node);
/// Block YAML that parse_yaml reads back to an equal tree; short sequences of numbers in flow style.
std::string to_yaml(const Node& node);

/// "name:line:column"
std::string place(const std::string& name, Mark mark);

/// The same values, wherever they were read from.
bool same_values(const Node& a, const Node& b);

}  // namespace scanmill::document
