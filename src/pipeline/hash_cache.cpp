// SPDX-License-Identifier: Apache-2.0
#include "pipeline/hash_cache.hpp"

#include <chrono>

#include "base/digest.hpp"

namespace scanmill::pipeline {

namespace {
constexpr std::int64_t kSettledNs = 2'000'000'000;  // coarser than any file system's time stamps (FAT: 2 s)

std::int64_t now_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::system_clock::now().time_since_epoch())
      .count();
}

void add_row(const std::string& path, const HashCache::Entry& entry, document::Node& tree) {
  if (!entry.trusted) return;
  document::Node row = document::Node::sequence();
  row.push(entry.stamp.size);
  row.push(entry.stamp.mtime_ns);
  row.push(entry.stamp.inode);
  row.push(entry.sha256);
  tree.entries().push_back({path, {}, std::move(row)});
}

}  // namespace

Result<HashCache::Entry> HashCache::entry_of(const std::string& path, const std::string& shown) {
  auto stamp = store::stamp_of(path);
  if (!stamp) return fail(stamp.error().code, stamp.error().message, shown);
  {
    const std::lock_guard<std::mutex> guard(mutex_);
    const auto found = entries_.find(path);
    if (found != entries_.end() && found->second.trusted && found->second.stamp == *stamp) return found->second;
  }
  const std::int64_t started = now_ns();
  TRY_ASSIGN(const auto source, store::open_file(path, shown));
  TRY_ASSIGN(const std::string sha256, sha256_of(*source));
  const auto after = store::stamp_of(path);
  if (!after || !(*after == *stamp))
    return fail(Code::BadInput, "the file changed while it was read; run again when its writer has finished", shown);
  Entry entry{*stamp, sha256, stamp->mtime_ns + kSettledNs < started};
  const std::lock_guard<std::mutex> guard(mutex_);
  entries_[path] = entry;
  return entry;
}

void HashCache::load(std::string_view text) {
  const auto tree = document::parse_json(text, "hashes");
  if (!tree || !tree->is_map()) return;
  const std::lock_guard<std::mutex> guard(mutex_);
  for (const auto& [path, mark, row] : tree->entries()) {
    if (!row.is_sequence() || row.items().size() != 4) continue;
    const auto& cell = row.items();
    if (!cell[0].is_integer() || !cell[1].is_integer() || !cell[2].is_integer() || !cell[3].is_string()) continue;
    Entry entry;
    entry.stamp.size = static_cast<std::uint64_t>(cell[0].as_integer());
    entry.stamp.mtime_ns = cell[1].as_integer();
    entry.stamp.inode = static_cast<std::uint64_t>(cell[2].as_integer());
    entry.sha256 = cell[3].as_string();
    entry.trusted = true;
    entries_[path] = std::move(entry);
  }
}

bool HashCache::knows(const std::string& path) const {
  const auto stamp = store::stamp_of(path);
  const std::lock_guard<std::mutex> guard(mutex_);
  const auto found = entries_.find(path);
  return stamp && found != entries_.end() && found->second.trusted && found->second.stamp == *stamp;
}

std::string HashCache::save() const {
  const std::lock_guard<std::mutex> guard(mutex_);
  std::string text = "{";
  for (const auto& [path, entry] : entries_) {  // a tree of all would take eight times the memory
    document::Node row = document::Node::map();
    add_row(path, entry, row);
    if (row.entries().empty()) continue;
    const std::string lines = document::to_json(row, 1);
    text += text.size() > 1 ? "," : "";
    text.append(lines, 1, lines.size() - 3);  // without "{" and "\n}"
  }
  return text + (text.size() > 1 ? "\n}\n" : "}\n");
}

std::string HashCache::save(std::span<const std::string> paths) const {
  const std::lock_guard<std::mutex> guard(mutex_);
  document::Node tree = document::Node::map();
  for (const std::string& path : paths)
    if (const auto found = entries_.find(path); found != entries_.end()) add_row(path, found->second, tree);
  return document::to_json(tree) + "\n";
}

}  // namespace scanmill::pipeline
