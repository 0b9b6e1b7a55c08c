// SPDX-License-Identifier: Apache-2.0
#include "stars/complex.hpp"

#include <algorithm>

namespace scanmill::stars {

void Fan::add(std::uint32_t triangle) {
  if (size_ == capacity_) {
    const auto larger = static_cast<std::uint16_t>(capacity_ * 2);
    auto* moved = new std::uint32_t[larger];
    std::copy(begin(), end(), moved);
    delete[] heap_;
    heap_ = moved;
    capacity_ = larger;
  }
  data()[size_++] = triangle;
}

void Fan::remove(std::uint32_t triangle) {
  std::uint32_t* first = data();
  std::uint32_t* found = std::find(first, first + size_, triangle);
  std::copy(found + 1, first + size_, found);
  --size_;
}

Complex::Complex(std::span<const std::uint8_t> kept)
    : fans_(kept.size()), kept_(kept.begin(), kept.end()), open_at_(kept.size(), 0) {
  for (const std::uint8_t k : kept_) unused_ += k != 0;
}

void Complex::count_edges(const Triangle& t, int sign) {
  for (std::size_t e = 0; e < 3; ++e) {
    const std::uint32_t a = t[e], b = t[(e + 1) % 3];
    const int change = half(b, a) != kNone ? -sign : sign;  // a partner closes both half-edges' question
    open_edges_ += change;
    open_at_[a] = static_cast<std::uint16_t>(open_at_[a] + change);
    open_at_[b] = static_cast<std::uint16_t>(open_at_[b] + change);
  }
}

void Complex::link(std::uint32_t t) {
  alive_[t] = 1;
  count_edges(triangles_[t], 1);
  for (const std::uint32_t v : triangles_[t]) {
    if (fans_[v].empty() && kept_[v]) --unused_;
    fans_[v].add(t);
  }
}

void Complex::unlink(std::uint32_t t) {
  alive_[t] = 0;
  for (const std::uint32_t v : triangles_[t]) {
    fans_[v].remove(t);
    if (fans_[v].empty() && kept_[v]) ++unused_;
  }
  count_edges(triangles_[t], -1);
}

void Complex::reserve(std::size_t triangles) {
  triangles_.reserve(triangles);
  alive_.reserve(triangles);
  votes_.reserve(triangles);
}

std::uint32_t Complex::add(const Triangle& t, int votes) {
  Triangle canonical = t;
  std::rotate(canonical.begin(), std::min_element(canonical.begin(), canonical.end()), canonical.end());
  const auto number = static_cast<std::uint32_t>(triangles_.size());
  triangles_.push_back(canonical);
  alive_.push_back(0);
  votes_.push_back(static_cast<std::uint8_t>(votes));
  link(number);
  if (logging_) journal_.push_back({Change::Added, number});
  return number;
}

void Complex::remove(std::uint32_t t) {
  unlink(t);
  if (logging_) journal_.push_back({Change::Removed, t});
}

void Complex::revive(std::uint32_t v) {
  kept_[v] = 1;
  if (fans_[v].empty()) ++unused_;
  if (logging_) journal_.push_back({Change::Revived, v});
}

void Complex::begin() {
  journal_.clear();
  logging_ = true;
}

void Complex::keep() {
  logging_ = false;
  journal_.clear();
}

void Complex::undo() {
  logging_ = false;
  for (auto change = journal_.rbegin(); change != journal_.rend(); ++change) switch (change->kind) {
      case Change::Added:
        unlink(change->what);
        break;
      case Change::Removed:
        link(change->what);
        break;
      case Change::Revived:
        if (fans_[change->what].empty()) --unused_;
        kept_[change->what] = 0;
        break;
    }
  journal_.clear();
}

std::vector<std::uint32_t> Complex::touched() const {
  std::vector<std::uint32_t> list;
  for (const Change& change : journal_)
    if (change.kind != Change::Revived) list.push_back(change.what);
  return list;
}

bool Complex::single_fan(std::uint32_t v) const {
  const Fan& fan = fans_[v];
  if (fan.size() < 2) return true;
  constexpr std::size_t kMost = 64;
  if (fan.size() > kMost) {
    std::vector<std::vector<std::uint32_t>> groups;
    split_fans(v, groups);
    return groups.size() == 1;
  }
  std::uint32_t from[kMost], to[kMost];
  std::size_t count = 0;
  for (const std::uint32_t t : fan) {
    after(t, v, from[count], to[count]);
    ++count;
  }
  // Forward from the first triangle's far side until the fan closes or ends, then backward from its near side.
  std::size_t met = 1;
  auto walk = [&](const std::uint32_t* near, const std::uint32_t* far, std::uint32_t at, std::uint32_t until) {
    while (met <= count) {
      std::size_t k = 0;
      while (k < count && near[k] != at) ++k;
      if (k == count) return false;
      at = far[k];
      ++met;
      if (at == until) return true;
    }
    return true;
  };
  if (to[0] == from[0]) return false;
  if (!walk(from, to, to[0], from[0])) walk(to, from, from[0], kNone);
  return met == count;
}

void Complex::split_fans(std::uint32_t v, std::vector<std::vector<std::uint32_t>>& groups) const {
  groups.clear();
  std::vector<std::uint32_t> left(fans_[v].begin(), fans_[v].end());
  std::sort(left.begin(), left.end());
  while (!left.empty()) {
    std::vector<std::uint32_t> group{left.front()};
    left.erase(left.begin());
    for (std::size_t at = 0; at < group.size(); ++at) {
      std::uint32_t a, b;
      after(group[at], v, a, b);
      for (std::size_t k = 0; k < left.size();) {
        std::uint32_t c, d;
        after(left[k], v, c, d);
        if (c == b || d == a) {
          group.push_back(left[k]);
          left.erase(left.begin() + static_cast<std::ptrdiff_t>(k));
        } else {
          ++k;
        }
      }
    }
    std::sort(group.begin(), group.end());
    groups.push_back(std::move(group));
  }
}

}  // namespace scanmill::stars
