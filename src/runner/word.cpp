// SPDX-License-Identifier: Apache-2.0
#include "runner/word.hpp"

#include <algorithm>
#include <mutex>
#include <set>

namespace scanmill::runner {

using document::Node;

Word::Word(std::string_view text) {
  static std::mutex mutex;
  static std::set<std::string, std::less<>> known;
  const std::lock_guard<std::mutex> guard(mutex);
  auto at = known.find(text);
  if (at == known.end()) at = known.emplace(text).first;
  text_ = &*at;
}

Counts::Counts(const Node& map) : known_(map.is_map()) {
  if (!known_) return;
  rows_.reserve(map.entries().size());
  for (const Node::Entry& entry : map.entries()) set(entry.key, entry.value);
}

std::optional<Node> Counts::find(std::string_view name) const {
  for (const Row& row : rows_)
    if (row.name.text() == name) return row.value();
  return std::nullopt;
}

void Counts::set(std::string_view name, const Node& number) {
  known_ = true;
  if (!number.is_number()) return;
  Row row{Word(name), number.is_integer(), {0}};
  if (row.whole)
    row.integer = number.as_integer();
  else
    row.number = number.as_number();
  const auto at = std::find_if(rows_.begin(), rows_.end(), [&](const Row& other) { return other.name == row.name; });
  if (at == rows_.end())
    rows_.push_back(row);
  else
    *at = row;
}

Node Counts::document() const {
  if (!known_) return {};
  Node map = Node::map();
  map.entries().reserve(rows_.size());
  for (const Row& row : rows_) map.set(row.name.text(), row.value());
  return map;
}

}  // namespace scanmill::runner
