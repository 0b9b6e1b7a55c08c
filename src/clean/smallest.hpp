// SPDX-License-Identifier: Apache-2.0
// The items with the least hashes: a sample of fixed size that depends on what was offered, never on the order, the
// parts or the threads it came in.
#pragma once
#include <algorithm>
#include <cstdint>
#include <limits>
#include <vector>

namespace scanmill::clean {

/// `Item` has operator<, total on items of equal hash that differ.
template <class Item>
class Smallest {
 public:
  explicit Smallest(std::size_t size) : size_(size) {}
  /// Whether an item of this hash may be among the least; others need not be offered.
  bool wants(std::uint64_t hash) const { return hash <= greatest_; }
  std::uint64_t greatest_wanted() const { return greatest_; }
  void offer(std::uint64_t hash, const Item& item) {
    if (!wants(hash)) return;
    entries_.push_back({hash, item});
    if (entries_.size() >= 2 * size_) cut();
  }
  void offer(const Smallest& other) {
    for (const Entry& entry : other.entries_) offer(entry.hash, entry.item);
  }
  /// At most `size` items, ascending (hash, item).
  std::vector<Item> sorted() const {
    std::vector<Entry> entries = entries_;
    std::sort(entries.begin(), entries.end());
    std::vector<Item> items;
    for (std::size_t i = 0; i < std::min(size_, entries.size()); ++i) items.push_back(entries[i].item);
    return items;
  }

 private:
  struct Entry {
    std::uint64_t hash;
    Item item;
    bool operator<(const Entry& other) const { return hash != other.hash ? hash < other.hash : item < other.item; }
  };
  void cut() {
    std::nth_element(entries_.begin(), entries_.begin() + static_cast<std::ptrdiff_t>(size_ - 1), entries_.end());
    entries_.resize(size_);
    greatest_ = entries_.back().hash;
  }

  std::size_t size_;
  std::uint64_t greatest_ = std::numeric_limits<std::uint64_t>::max();
  std::vector<Entry> entries_;
};

}  // namespace scanmill::clean
