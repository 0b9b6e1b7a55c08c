// SPDX-License-Identifier: Apache-2.0
#include "mesh/mesh.hpp"

#include <algorithm>
#include <numeric>

#include "mesh/groups.hpp"

namespace scanmill {
namespace {

struct HalfEdge {
  std::uint64_t edge;    // lesser vertex << 32 | greater
  std::uint32_t corner;  // 3 t + e
  bool forward;          // runs from the lesser to the greater vertex
};

std::vector<HalfEdge> half_edges_by_edge(std::span<const Triangle> triangles) {
  std::vector<HalfEdge> list;
  list.reserve(triangles.size() * 3);
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    const auto [p, q, r] = triangles[t];
    if (p == q || q == r || r == p) continue;  // names a vertex twice: no edges
    for (std::uint32_t e = 0; e < 3; ++e) {
      const std::uint64_t a = triangles[t][e], b = triangles[t][(e + 1) % 3];
      list.push_back({a < b ? a << 32 | b : b << 32 | a, 3 * t + e, a < b});
    }
  }
  std::sort(list.begin(), list.end(), [](const HalfEdge& a, const HalfEdge& b) {
    return a.edge != b.edge ? a.edge < b.edge : a.corner < b.corner;
  });
  return list;
}

}  // namespace

std::vector<std::uint32_t> edge_neighbours(std::size_t vertex_count, std::span<const Triangle> triangles) {
  // Half-edges in buckets by their lesser vertex; a bucket holds a handful.
  std::vector<std::uint32_t> first(vertex_count + 1, 0);
  for (const Triangle& t : triangles)
    for (std::size_t e = 0; e < 3; ++e) ++first[std::min(t[e], t[(e + 1) % 3]) + 1];
  std::partial_sum(first.begin(), first.end(), first.begin());
  struct Half {
    std::uint32_t greater, corner;
  };
  std::vector<Half> halves(triangles.size() * 3);
  std::vector<std::uint32_t> next(first.begin(), first.end() - 1);
  for (std::uint32_t t = 0; t < triangles.size(); ++t)
    for (std::uint32_t e = 0; e < 3; ++e) {
      const std::uint32_t a = triangles[t][e], b = triangles[t][(e + 1) % 3];
      halves[next[std::min(a, b)]++] = {std::max(a, b), 3 * t + e};
    }
  std::vector<std::uint32_t> across(triangles.size() * 3, kNoTriangle);
  std::vector<std::uint32_t> others;  // of each half-edge of a bucket, on the same edge
  for (std::size_t v = 0; v < vertex_count; ++v) {
    const std::span<const Half> bucket(halves.data() + first[v], first[v + 1] - first[v]);
    others.assign(bucket.size(), 0);
    for (std::size_t i = 0; i < bucket.size(); ++i)
      for (std::size_t j = i + 1; j < bucket.size(); ++j) {
        if (bucket[i].greater != bucket[j].greater) continue;
        ++others[i];
        ++others[j];
        across[bucket[i].corner] = bucket[j].corner / 3;
        across[bucket[j].corner] = bucket[i].corner / 3;
      }
    for (std::size_t i = 0; i < bucket.size(); ++i)
      if (others[i] != 1) across[bucket[i].corner] = kNoTriangle;
  }
  return across;
}

std::vector<BorderLoop> border_loops(const Mesh& mesh) {
  const auto across = edge_neighbours(mesh.positions.size(), mesh.triangles);
  std::vector<std::uint8_t> done(across.size(), 0);
  std::vector<BorderLoop> loops;
  auto from = [&](std::uint32_t c) { return mesh.triangles[c / 3][c % 3]; };
  auto to = [&](std::uint32_t c) { return mesh.triangles[c / 3][(c % 3 + 1) % 3]; };
  auto far_end = [&](std::uint32_t c, std::uint32_t v) { return from(c) == v ? to(c) : from(c); };
  // From one open edge at v to the other open edge of the same fan. Triangles are not trusted to agree in direction
  // (the walk must end on a Moebius strip too): neighbours are mutual, so a fan is a path and this reaches its other
  // end.
  auto next = [&](std::uint32_t c, std::uint32_t v) {
    for (;;) {
      const std::uint32_t t = c / 3, e = c % 3;
      c = 3 * t + (from(c) == v ? (e + 2) % 3 : (e + 1) % 3);
      if (across[c] == kNoTriangle) return c;
      const std::uint32_t u = far_end(c, v);
      c = 3 * across[c];
      while (!((from(c) == v && to(c) == u) || (from(c) == u && to(c) == v))) ++c;
    }
  };
  for (std::uint32_t start = 0; start < across.size(); ++start) {
    if (across[start] != kNoTriangle || done[start]) continue;
    BorderLoop loop;
    std::uint32_t c = start, v = from(start);  // the missing triangle's edge runs against that of the one that is there
    do {
      done[c] = 1;
      loop.vertices.push_back(far_end(c, v));
      c = next(c, v);
      v = far_end(c, v);
    } while (!done[c]);
    std::rotate(loop.vertices.begin(), std::min_element(loop.vertices.begin(), loop.vertices.end()),
                loop.vertices.end());
    Vec3 sum;
    for (std::size_t i = 0; i < loop.vertices.size(); ++i) {
      const Vec3 p = mesh.positions[loop.vertices[i]],
                 q = mesh.positions[loop.vertices[(i + 1) % loop.vertices.size()]];
      loop.length_mm += norm(q - p);
      sum += p;
    }
    loop.centre = sum * (1 / static_cast<double>(loop.vertices.size())) + mesh.offset;
    loops.push_back(std::move(loop));
  }
  std::sort(loops.begin(), loops.end(),
            [](const BorderLoop& a, const BorderLoop& b) { return a.vertices < b.vertices; });
  return loops;
}

TopologyCounts topology_of(const Mesh& mesh) {
  TopologyCounts counts;
  const auto& triangles = mesh.triangles;
  counts.triangles = triangles.size();
  const auto list = half_edges_by_edge(triangles);
  Groups corners(triangles.size() * 3), vertices(mesh.positions.size()), borders(mesh.positions.size());
  std::vector<std::uint8_t> used(mesh.positions.size(), 0), on_border(mesh.positions.size(), 0);
  auto corner_at = [&](std::uint32_t t, std::uint32_t v) {
    for (std::uint32_t k = 0; k < 3; ++k)
      if (triangles[t][k] == v) return 3 * t + k;
    return 3 * t;
  };
  for (std::size_t i = 0, j; i < list.size(); i = j) {
    for (j = i; j < list.size() && list[j].edge == list[i].edge;) ++j;
    ++counts.edges;
    const auto a = static_cast<std::uint32_t>(list[i].edge >> 32), b = static_cast<std::uint32_t>(list[i].edge);
    if (j - i == 1) {
      ++counts.boundary_edges;
      on_border[a] = on_border[b] = 1;
      borders.join(a, b);
    } else if (j - i > 2) {
      ++counts.nonmanifold_edges;
    } else {
      if (list[i].forward == list[i + 1].forward) ++counts.misoriented_edges;
      for (const std::uint32_t v : {a, b})
        corners.join(corner_at(list[i].corner / 3, v), corner_at(list[i + 1].corner / 3, v));
    }
  }
  std::vector<std::uint32_t> fan(mesh.positions.size(), kNoTriangle);
  std::vector<std::uint8_t> split(mesh.positions.size(), 0);
  for (std::uint32_t c = 0; c < triangles.size() * 3; ++c) {
    const std::uint32_t v = triangles[c / 3][c % 3], root = corners.root(c);
    vertices.join(triangles[c / 3][0], v);
    used[v] = 1;
    if (fan[v] == kNoTriangle)
      fan[v] = root;
    else if (fan[v] != root)
      split[v] = 1;
  }
  for (std::uint32_t v = 0; v < mesh.positions.size(); ++v) {
    counts.nonmanifold_vertices += split[v];
    if (!used[v]) continue;
    ++counts.vertices_used;
    counts.components += vertices.root(v) == v;
    counts.boundary_loops += on_border[v] && borders.root(v) == v;
  }
  counts.euler = static_cast<std::int64_t>(counts.vertices_used) - static_cast<std::int64_t>(counts.edges) +
                 static_cast<std::int64_t>(counts.triangles);
  return counts;
}

std::vector<std::uint8_t> single_fan_triangles(std::size_t vertex_count, std::span<const Triangle> triangles) {
  std::vector<std::uint8_t> stays(triangles.size(), 1);
  const auto across = edge_neighbours(vertex_count, triangles);
  auto corner_of = [&](std::uint32_t t, std::uint32_t v) {
    std::uint32_t k = 0;
    while (triangles[t][k] != v) ++k;
    return 3 * t + k;
  };
  for (bool changed = true; changed;) {
    changed = false;
    Groups corners(triangles.size() * 3);
    for (std::uint32_t c = 0; c < across.size(); ++c) {
      const std::uint32_t other = across[c];
      if (!stays[c / 3] || other == kNoTriangle || !stays[other]) continue;
      for (const std::uint32_t k : {c % 3, (c % 3 + 1) % 3})
        corners.join(3 * (c / 3) + k, corner_of(other, triangles[c / 3][k]));
    }
    std::vector<std::uint32_t> size(triangles.size() * 3, 0), best(vertex_count, kNoTriangle);
    for (std::uint32_t c = 0; c < across.size(); ++c)
      if (stays[c / 3]) ++size[corners.root(c)];
    for (std::uint32_t c = 0; c < across.size(); ++c) {
      if (!stays[c / 3] || corners.root(c) != c) continue;
      std::uint32_t& largest = best[triangles[c / 3][c % 3]];
      if (largest == kNoTriangle || size[c] > size[largest]) largest = c;
    }
    for (std::uint32_t c = 0; c < across.size(); ++c)
      if (stays[c / 3] && corners.root(c) != best[triangles[c / 3][c % 3]]) {
        stays[c / 3] = 0;
        changed = true;
      }
  }
  return stays;
}

double signed_volume(const Mesh& mesh) {
  double sum = 0;
  for (const Triangle& t : mesh.triangles)
    sum += dot(mesh.positions[t[0]], cross(mesh.positions[t[1]], mesh.positions[t[2]]));
  return sum / 6;
}

}  // namespace scanmill
