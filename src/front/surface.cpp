// SPDX-License-Identifier: Apache-2.0
#include "front/surface.hpp"

#include <algorithm>

namespace scanmill::front {
namespace {

std::uint32_t after(const Triangle& t, std::uint32_t v) { return t[0] == v ? t[1] : t[1] == v ? t[2] : t[0]; }
std::uint32_t before(const Triangle& t, std::uint32_t v) { return t[0] == v ? t[2] : t[1] == v ? t[0] : t[1]; }

}  // namespace

Facet Surface::make_facet(const Triangle& corners) const {
  Facet facet;
  facet.rows = corners;
  for (std::size_t i = 0; i < 3; ++i) facet.corners[i] = points_[corners[i]];
  facet.normal = unit(cross(facet.corners[1] - facet.corners[0], facet.corners[2] - facet.corners[0]));
  return facet;
}

std::uint32_t Surface::owner(std::uint32_t a, std::uint32_t b) const {
  for (const std::uint32_t t : around_[a])
    if (after(triangles_[t], a) == b) return t;
  return kNoTriangle;
}

bool Surface::has_room(const Triangle& c) const {
  return owner(c[0], c[1]) == kNoTriangle && owner(c[1], c[2]) == kNoTriangle && owner(c[2], c[0]) == kNoTriangle;
}

void Surface::add(const Triangle& corners, const Facet& facet, std::uint32_t patch) {
  const auto t = static_cast<std::uint32_t>(triangles_.size());
  triangles_.push_back(corners);
  facets_.push_back(facet);
  patches_.push_back(patch);
  alive_.push_back(1);
  for (const std::uint32_t v : corners) around_[v].push_back(t);
}

void Surface::remove(std::uint32_t t) {
  alive_[t] = 0;
  for (const std::uint32_t v : triangles_[t]) std::erase(around_[v], t);
}

bool Surface::closed(std::uint32_t v) const {
  if (around_[v].empty()) return false;
  for (const std::uint32_t t : around_[v])
    if (owner(after(triangles_[t], v), v) == kNoTriangle || owner(v, before(triangles_[t], v)) == kNoTriangle)
      return false;
  return true;
}

bool Surface::single_gap(std::uint32_t v, std::uint32_t& u, std::uint32_t& w) const {
  int incoming = 0, outgoing = 0;
  for (const std::uint32_t t : around_[v]) {
    const std::uint32_t next = after(triangles_[t], v), last = before(triangles_[t], v);
    if (owner(next, v) == kNoTriangle) ++outgoing, w = next;
    if (owner(v, last) == kNoTriangle) ++incoming, u = last;
  }
  return incoming == 1 && outgoing == 1;
}

std::uint32_t Surface::fans_at(std::uint32_t v, std::vector<std::uint32_t>& fan) const {
  const auto& list = around_[v];
  fan.assign(list.size(), kNoTriangle);
  std::uint32_t fans = 0;
  std::vector<std::size_t> open;
  for (std::size_t start = 0; start < list.size(); ++start) {
    if (fan[start] != kNoTriangle) continue;
    fan[start] = fans;
    open.assign(1, start);
    while (!open.empty()) {
      const Triangle& t = triangles_[list[open.back()]];
      open.pop_back();
      for (std::size_t i = 0; i < list.size(); ++i) {
        const Triangle& other = triangles_[list[i]];
        if (fan[i] == kNoTriangle && (before(other, v) == after(t, v) || after(other, v) == before(t, v))) {
          fan[i] = fans;
          open.push_back(i);
        }
      }
    }
    ++fans;
  }
  return fans;
}

void Surface::remove_lesser_fans() {
  std::vector<std::uint32_t> fan, work(around_.size());
  for (std::uint32_t v = 0; v < work.size(); ++v) work[v] = static_cast<std::uint32_t>(work.size()) - 1 - v;
  while (!work.empty()) {  // a stack: least vertex first, then what a removal touched
    const std::uint32_t v = work.back();
    work.pop_back();
    const std::uint32_t fans = fans_at(v, fan);
    if (fans < 2) continue;
    std::vector<std::size_t> sizes(fans, 0);
    for (const std::uint32_t f : fan) ++sizes[f];
    // Fans are numbered by their oldest triangle, so the first of the largest is the one with the least triangle.
    const auto kept = static_cast<std::uint32_t>(std::max_element(sizes.begin(), sizes.end()) - sizes.begin());
    const std::vector<std::uint32_t> list = around_[v];
    for (std::size_t i = 0; i < list.size(); ++i) {
      if (fan[i] == kept) continue;
      remove(list[i]);
      for (const std::uint32_t touched : triangles_[list[i]]) work.push_back(touched);
    }
  }
}

}  // namespace scanmill::front
