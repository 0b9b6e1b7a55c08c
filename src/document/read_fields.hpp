// SPDX-License-Identifier: Apache-2.0
// Parameter structs from and to document trees, driven by their field tables; and the list of all problems of a
// document.
#pragma once
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/fields.hpp"
#include "document/document.hpp"

namespace scanmill::document {

/// Collects every problem of one document, a line each: "name:line:column: key: what was found; allowed; nearest".
/// A value that came from the command line has no mark; its place is "command line".
class Problems {
 public:
  explicit Problems(std::string name) : name_(std::move(name)) {}
  void add(Mark mark, const std::string& key, const std::string& sentence);
  /// "prefix.key: unknown key; allowed a, b, c; nearest a"
  void add_unknown(const Node::Entry& entry, const std::string& prefix, std::span<const std::string_view> allowed);
  bool empty() const { return lines_.empty(); }
  /// The lines in the order of their places in the text.
  std::vector<std::string> lines() const;
  /// BadParameter with all lines.
  Error error() const;

 private:
  struct Line {
    Mark mark;
    std::string text;
  };
  std::string name_;
  std::vector<Line> lines_;
};

/// A scalar as a person would point at it: "yes" (a text), 7, a list.
std::string shown(const Node& node);
/// "a, b, c"
std::string joined(std::span<const std::string_view> words);

/// Reads one value into the member of `row`; `object` is the struct the row belongs to. `off` and null empty an
/// optional.
void read_field(const Node& value, const std::string& key, const Field& row, void* object, Problems& problems);
/// Reads a map into the struct of `table`. Keys named in `others` are the caller's; keys that begin with "x-" are
/// ignored.
void read_fields(const Node& section, const std::string& name, std::span<const Field> table, void* object,
                 std::span<const std::string_view> others, Problems& problems);
/// The value of one row; null for an empty optional.
Node field_value(const Field& row, const void* object);
/// Every row with its value, in the table's order.
Node fields_to_document(std::span<const Field> table, const void* object);
/// Draft-07 schema of one row (type, limits, words, help, default).
Node field_schema(const Field& row, const void* defaults);
/// The same for a whole section: an object that takes these keys, keys that begin with "x-", and no others.
Node fields_schema(std::span<const Field> table, const void* defaults, std::string_view help);

}  // namespace scanmill::document
