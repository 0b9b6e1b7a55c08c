// SPDX-License-Identifier: Apache-2.0
#include "runner/quarantine.hpp"

#include "document/document.hpp"
#include "store/files.hpp"

namespace scanmill::runner {

using document::Node;

Quarantine Quarantine::load(const std::string& path) {
  Quarantine result;
  if (!store::exists(path)) return result;
  const auto source = store::open_file(path, path);
  if (!source) return result;
  const auto text = read_all(**source, 64ull << 20);
  if (!text) return result;
  const auto tree = document::parse_json(*text, path);
  if (!tree || !tree->is_map()) return result;
  for (const Node::Entry& row : tree->entries()) {
    const Node* fingerprint = row.value.find("fingerprint");
    const Node* error = row.value.find("error");
    if (fingerprint && error && fingerprint->is_string() && error->is_string())
      result.entries_[row.key] = {fingerprint->as_string(), error->as_string()};
  }
  return result;
}

Result<void> Quarantine::save(const std::string& path) const {
  if (!changed_) return {};
  Node tree = Node::map();
  for (const auto& [scan, entry] : entries_) {
    Node row = Node::map();
    row.set("fingerprint", entry.fingerprint);
    row.set("error", entry.error);
    tree.entries().push_back({scan, {}, std::move(row)});
  }
  return store::write_text(path, document::to_json(tree, 1) + "\n");
}

const Quarantine::Entry* Quarantine::find(const std::string& scan, const std::string& fingerprint) const {
  const auto found = entries_.find(scan);
  return found != entries_.end() && found->second.fingerprint == fingerprint ? &found->second : nullptr;
}

void Quarantine::add(const std::string& scan, Entry entry) {
  entries_[scan] = std::move(entry);
  changed_ = true;
}

void Quarantine::remove(const std::string& scan) { changed_ = entries_.erase(scan) > 0 || changed_; }

}  // namespace scanmill::runner
