// SPDX-License-Identifier: Apache-2.0
#include "runner/worklist.hpp"

#include <algorithm>
#include <cmath>

namespace scanmill::runner {
namespace {

constexpr std::uint64_t kMiB = 1ull << 20;
constexpr std::uint64_t kBase = 96 * kMiB;  // program, threads, pictures
constexpr std::uint64_t kPerByte = 5;       // of the input; 60 bytes a point of a binary cloud, measured 25 to 50
constexpr int kMostPassedOver = 16;

/// Its part of the cores, by its part of the bytes that are left: a giant among dwarfs gets all.
int threads_for(const WorkItem& item, std::uint64_t bytes_left, std::size_t items_left, const Room& room) {
  if (items_left == 1) return room.cores_free;
  const double part = bytes_left > 0 ? static_cast<double>(item.bytes) / static_cast<double>(bytes_left)
                                     : 1.0 / static_cast<double>(items_left);
  return std::clamp(static_cast<int>(std::lround(part * room.cores)), 1, room.cores_free);
}

}  // namespace

std::uint64_t memory_guess(std::uint64_t bytes) { return kBase + kPerByte * bytes; }

void Worklist::add(const WorkItem& item) {
  const auto before = [](const Entry& a, const Entry& b) {
    return a.item.bytes != b.item.bytes ? a.item.bytes > b.item.bytes : a.item.scan < b.item.scan;
  };
  const Entry entry{item, 0};
  items_.insert(std::upper_bound(items_.begin(), items_.end(), entry, before), entry);
  bytes_ += item.bytes;
}

std::size_t Worklist::scans_beside(const std::set<std::size_t>& scans) const {
  std::size_t count = 0;
  std::set<std::size_t> of_parts;
  for (const Entry& entry : items_) {
    if (scans.contains(entry.item.scan)) continue;
    if (entry.item.part.empty())
      ++count;
    else
      of_parts.insert(entry.item.scan);
  }
  return count + of_parts.size();
}

std::optional<std::pair<WorkItem, Order>> Worklist::next(const Room& room, Moment now) {
  if (room.cores_free < 1) return std::nullopt;
  for (auto entry = items_.begin(); entry != items_.end(); ++entry) {
    const WorkItem& item = entry->item;
    if (item.not_before > now) continue;
    const int threads = threads_for(item, bytes_, items_.size(), room);
    Order order{item.scan, threads, 0, item.part, item.part.empty() ? 0 : item.bytes};
    if (room.memory > 0) {
      const std::uint64_t wanted = std::min(room.memory, std::max(item.memory, memory_guess(item.bytes)));
      const std::uint64_t share =
          room.memory / static_cast<std::uint64_t>(room.cores) * static_cast<std::uint64_t>(threads);
      if (wanted > room.memory_free) {
        if (++entry->passed_over > kMostPassedOver) return std::nullopt;
        continue;
      }
      order.memory = std::min(room.memory_free, std::max(wanted, share));
    }
    std::pair<WorkItem, Order> taken{item, order};
    bytes_ -= item.bytes;
    items_.erase(entry);
    return taken;
  }
  return std::nullopt;
}

std::optional<Moment> Worklist::next_moment(Moment now) const {
  std::optional<Moment> first;
  for (const Entry& entry : items_)
    if (entry.item.not_before > now && (!first || entry.item.not_before < *first)) first = entry.item.not_before;
  return first;
}

Worklist::Waits Worklist::waits(Moment now) const {
  Waits waits;
  for (const Entry& entry : items_) {
    if (entry.item.not_before <= now) continue;
    ++waits.count;
    waits.last = std::max(waits.last, entry.item.not_before);
  }
  return waits;
}

void Worklist::drop(std::size_t scan) {
  std::erase_if(items_, [&](const Entry& entry) {
    if (entry.item.scan == scan) bytes_ -= entry.item.bytes;
    return entry.item.scan == scan;
  });
}

std::vector<WorkItem> Worklist::drop_all() {
  std::vector<WorkItem> items;
  for (const Entry& entry : items_) items.push_back(entry.item);
  items_.clear();
  bytes_ = 0;
  return items;
}

}  // namespace scanmill::runner
