// SPDX-License-Identifier: Apache-2.0
#include "verify/edges.hpp"

#include <algorithm>
#include <numeric>

namespace scanmill::verify {

Edges edges_of(std::size_t vertex_count, std::span<const Triangle> triangles) {
  // Corners in buckets by the lesser vertex of their edge; a bucket holds a handful, sorted by (greater vertex,
  // corner).
  std::vector<std::uint32_t> next(vertex_count + 1, 0);
  for (const Triangle& t : triangles) {
    if (names_a_vertex_twice(t)) continue;
    for (std::size_t e = 0; e < 3; ++e) ++next[std::min(t[e], t[(e + 1) % 3]) + 1];
  }
  std::partial_sum(next.begin(), next.end(), next.begin());
  struct Half {
    std::uint32_t greater, corner;
  };
  std::vector<Half> halves(next.back());
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    if (names_a_vertex_twice(triangles[t])) continue;
    for (std::uint32_t e = 0; e < 3; ++e) {
      const std::uint32_t a = triangles[t][e], b = triangles[t][(e + 1) % 3];
      halves[next[std::min(a, b)]++] = {std::max(a, b), 3 * t + e};
    }
  }
  Edges edges;
  edges.corners.resize(halves.size());
  edges.first.reserve(halves.size() / 2 + 2);
  std::uint32_t begin = 0;
  for (std::size_t v = 0; v < vertex_count; ++v) {
    const std::uint32_t end = next[v];  // by now the end of its own bucket
    std::sort(halves.begin() + begin, halves.begin() + end, [](const Half& a, const Half& b) {
      return a.greater != b.greater ? a.greater < b.greater : a.corner < b.corner;
    });
    for (std::uint32_t i = begin; i < end; ++i) {
      if (i == begin || halves[i].greater != halves[i - 1].greater) edges.first.push_back(i);
      edges.corners[i] = halves[i].corner;
    }
    begin = end;
  }
  edges.first.push_back(begin);
  return edges;
}

std::vector<std::uint32_t> across_of(const Edges& edges, std::size_t triangle_count) {
  std::vector<std::uint32_t> across(triangle_count * 3, kNoEdge);
  for (std::size_t n = 0; n < edges.size(); ++n) {
    const auto corners = edges.at(n);
    if (corners.size() == 2) {
      across[corners[0]] = corners[1] / 3;
      across[corners[1]] = corners[0] / 3;
    } else {
      for (const std::uint32_t c : corners) across[c] = corners.size() == 1 ? kOpenEdge : kCrowdedEdge;
    }
  }
  return across;
}

}  // namespace scanmill::verify
