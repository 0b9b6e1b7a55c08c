// SPDX-License-Identifier: Apache-2.0
#include "runner/quarantine.hpp"

#include "document/document.hpp"
#include "store/files.hpp"

namespace scanmill::runner {

using document::Node;

namespace {

Quarantine::Entry entry_of(const Node& row, const std::string& fingerprint, const std::string& error) {
  Quarantine::Entry entry{fingerprint, error, FailureClass::BadInput, {}, 1, 0, 0, 0};
  const Node *failure = row.find("class"), *since = row.find("since"), *attempts = row.find("attempts"),
             *memory = row.find("memory_bytes"), *limit = row.find("time_limit_s"), *disk = row.find("disk_bytes");
  if (failure && failure->is_string()) entry.failure = failure_named(failure->as_string());
  if (since && since->is_string()) entry.since = since->as_string();
  if (attempts && attempts->is_integer()) entry.attempts = static_cast<int>(attempts->as_integer());
  if (memory && memory->is_integer()) entry.memory = static_cast<std::uint64_t>(memory->as_integer());
  if (limit && limit->is_number()) entry.time_limit_s = limit->as_number();
  if (disk && disk->is_integer()) entry.disk = static_cast<std::uint64_t>(disk->as_integer());
  return entry;
}

}  // namespace

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
      result.entries_[row.key] = entry_of(row.value, fingerprint->as_string(), error->as_string());
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
    row.set("class", name_of(entry.failure));
    row.set("since", entry.since);
    row.set("attempts", entry.attempts);
    if (entry.memory > 0) row.set("memory_bytes", entry.memory);
    if (entry.time_limit_s > 0) row.set("time_limit_s", entry.time_limit_s);
    if (entry.disk > 0) row.set("disk_bytes", entry.disk);
    tree.entries().push_back({scan, {}, std::move(row)});
  }
  return store::write_text(path, document::to_json(tree, 1) + "\n");
}

const Quarantine::Entry* Quarantine::find(const std::string& scan, const std::string& fingerprint,
                                          const Limits& limits) const {
  const auto found = entries_.find(scan);
  if (found == entries_.end() || found->second.fingerprint != fingerprint) return nullptr;
  const Entry& entry = found->second;
  const auto lifted = [](auto had, auto has) { return had > 0 && (has == 0 || has > had); };
  const bool has_more = lifted(entry.memory, limits.memory) || lifted(entry.time_limit_s, limits.time_limit_s) ||
                        lifted(entry.disk, limits.disk);
  return has_more ? nullptr : &entry;
}

void Quarantine::add(const std::string& scan, Entry entry) {
  entries_[scan] = std::move(entry);
  changed_ = true;
}

bool Quarantine::remove(const std::string& scan) {
  const bool was_there = entries_.erase(scan) > 0;
  changed_ = changed_ || was_there;
  return was_there;
}

std::vector<std::string> Quarantine::names() const {
  std::vector<std::string> names;
  for (const auto& [scan, entry] : entries_) names.push_back(scan);
  return names;
}

}  // namespace scanmill::runner
