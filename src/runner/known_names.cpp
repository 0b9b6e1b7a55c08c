// SPDX-License-Identifier: Apache-2.0
#include "runner/known_names.hpp"

#include "document/document.hpp"
#include "store/files.hpp"

namespace scanmill::runner {

using document::Node;

namespace {
constexpr std::uint64_t kLongestList = 256ull << 20;
}  // namespace

std::set<std::string> load_names(const OutputTree& tree) {
  const auto source = store::open_file(tree.names_file(), tree.names_file());
  if (!source) return {};
  const auto text = read_all(**source, kLongestList);
  if (!text) return {};
  const auto list = document::parse_json(*text, tree.names_file());
  const Node* scans = list && list->is_map() ? list->find("scans") : nullptr;
  if (!scans || !scans->is_sequence()) return {};
  std::set<std::string> names;
  for (const Node& name : scans->items())
    if (name.is_string()) names.insert(name.as_string());
  return names;
}

Result<void> save_names(const std::vector<std::string>& names, const OutputTree& tree) {
  Node scans = Node::sequence();
  for (const std::string& name : names) scans.push(name);
  Node list = Node::map();
  list.set("scanmill_names", 1);
  list.set("scans", std::move(scans));
  return store::write_text(tree.names_file(), document::to_json(list) + "\n");
}

}  // namespace scanmill::runner
