// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "stars/complete.hpp"

namespace scanmill::stars {
namespace {

/// The hole's next missing half-edge a -> w after b -> a; where several holes meet at a, the one with the smallest
/// turn.
std::uint32_t next_open(const Site& site, std::uint32_t b, std::uint32_t a) {
  const double towards_b = site.angle_at(a, b);
  std::uint32_t found = kNone;
  double least = 1e9;
  for (const std::uint32_t t : site.complex.fan(a)) {
    std::uint32_t x, w;
    site.complex.after(t, a, x, w);
    if (site.complex.half(a, w) != kNone) continue;
    const double d = w == b ? 5 : Site::turn(site.angle_at(a, w), towards_b);
    if (d < least || (d == least && w < found)) {
      least = d;
      found = w;
    }
  }
  return found;
}

using Half = std::pair<std::uint32_t, std::uint32_t>;

}  // namespace

std::vector<std::uint32_t> open_vertices(const Site& site) {
  std::vector<std::uint32_t> list;
  for (std::uint32_t v = 0; v < site.complex.vertex_count(); ++v)
    if (site.complex.is_open(v)) list.push_back(v);
  return list;
}

std::vector<Loop> trace_loops(const Site& site, const std::vector<std::uint32_t>& vertices, std::size_t longest) {
  std::vector<Half> starts;
  for (const std::uint32_t v : vertices) {
    if (!site.complex.is_open(v)) continue;
    for (const std::uint32_t t : site.complex.fan(v)) {
      const Triangle& x = site.complex.triangle(t);
      for (std::size_t e = 0; e < 3; ++e)
        if (site.complex.half(x[(e + 1) % 3], x[e]) == kNone) starts.push_back({x[(e + 1) % 3], x[e]});
    }
  }
  std::sort(starts.begin(), starts.end());
  starts.erase(std::unique(starts.begin(), starts.end()), starts.end());
  std::vector<std::uint8_t> done(starts.size(), 0);
  auto mark = [&](const Half& half) {
    const auto at = std::lower_bound(starts.begin(), starts.end(), half);
    if (at != starts.end() && *at == half) done[static_cast<std::size_t>(at - starts.begin())] = 1;
  };
  std::vector<Loop> loops;
  for (std::size_t s = 0; s < starts.size(); ++s) {
    if (done[s]) continue;
    Loop loop;
    auto [p, q] = starts[s];
    bool closed = false;
    for (std::size_t step = 0; step <= longest; ++step) {
      mark({p, q});
      loop.push_back(p);
      const std::uint32_t w = next_open(site, p, q);
      if (w == kNone) break;
      p = q;
      q = w;
      if (p == starts[s].first && q == starts[s].second) {
        closed = true;
        break;
      }
    }
    if (!closed || loop.size() > longest) continue;
    std::rotate(loop.begin(), std::min_element(loop.begin(), loop.end()), loop.end());
    loops.push_back(std::move(loop));
  }
  std::sort(loops.begin(), loops.end(),
            [](const Loop& a, const Loop& b) { return a.size() != b.size() ? a.size() < b.size() : a < b; });
  loops.erase(std::unique(loops.begin(), loops.end()), loops.end());
  return loops;
}

std::size_t peel(Site& site, const std::vector<std::uint32_t>& vertices) {
  std::size_t removed = 0;
  std::vector<std::vector<std::uint32_t>> groups;
  for (const std::uint32_t v : vertices) {
    if (site.complex.single_fan(v)) continue;
    site.complex.split_fans(v, groups);
    std::size_t largest = 0;
    for (std::size_t g = 1; g < groups.size(); ++g)
      if (groups[g].size() > groups[largest].size()) largest = g;
    for (std::size_t g = 0; g < groups.size(); ++g) {
      if (g == largest) continue;
      for (const std::uint32_t t : groups[g])
        if (site.complex.alive(t)) {
          site.complex.remove(t);
          ++removed;
        }
    }
  }
  return removed;
}

}  // namespace scanmill::stars
