// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "grow/grow.hpp"

namespace scanmill::grow {

std::vector<std::vector<std::uint32_t>> patch_borders(std::span<const Triangle> triangles,
                                                      std::span<const std::uint32_t> patch, std::size_t vertex_count) {
  const auto across = edge_neighbours(vertex_count, triangles);
  std::vector<std::array<std::uint32_t, 2>> edges;  // lesser vertex first, each once
  for (std::uint32_t c = 0; c < across.size(); ++c) {
    const std::uint32_t other = across[c];
    if (other != kNoTriangle && (patch[other] == patch[c / 3] || other < c / 3)) continue;
    const std::uint32_t a = triangles[c / 3][c % 3], b = triangles[c / 3][(c % 3 + 1) % 3];
    edges.push_back({std::min(a, b), std::max(a, b)});
  }
  std::sort(edges.begin(), edges.end());
  // Both directions, by first vertex: the edges at a vertex are one range.
  std::vector<std::array<std::uint32_t, 2>> ends;  // vertex, edge
  for (std::uint32_t e = 0; e < edges.size(); ++e)
    for (const std::uint32_t v : edges[e]) ends.push_back({v, e});
  std::sort(ends.begin(), ends.end());
  auto range = [&](std::uint32_t v) {
    return std::equal_range(ends.begin(), ends.end(), std::array<std::uint32_t, 2>{v, 0},
                            [](const auto& x, const auto& y) { return x[0] < y[0]; });
  };
  std::vector<std::uint8_t> used(edges.size(), 0);
  std::vector<std::vector<std::uint32_t>> lines;
  auto follow = [&](std::uint32_t edge, std::uint32_t from) {
    std::vector<std::uint32_t> line{from};
    for (;;) {
      used[edge] = 1;
      const std::uint32_t to = edges[edge][0] == from ? edges[edge][1] : edges[edge][0];
      line.push_back(to);
      const auto [first, last] = range(to);
      if (last - first != 2) break;  // a node where borders meet
      const std::uint32_t next = (*first)[1] == edge ? (*(first + 1))[1] : (*first)[1];
      if (used[next]) break;
      edge = next;
      from = to;
    }
    lines.push_back(std::move(line));
  };
  for (std::uint32_t e = 0; e < edges.size(); ++e)
    for (const std::uint32_t v : edges[e]) {
      const auto [first, last] = range(v);
      if (!used[e] && last - first != 2) follow(e, v);
    }
  for (std::uint32_t e = 0; e < edges.size(); ++e)
    if (!used[e]) follow(e, edges[e][0]);  // closed lines without nodes
  return lines;
}

}  // namespace scanmill::grow
