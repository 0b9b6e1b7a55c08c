// SPDX-License-Identifier: Apache-2.0
#include "surfaces/borders.hpp"

#include <algorithm>

namespace scanmill::surfaces {
namespace {

/// Half-edges (3 t + corner) of charts that run along a border.
class Border {
 public:
  Border(const Mesh& mesh, const std::vector<std::uint32_t>& neighbours, const Charts& charts)
      : mesh_(mesh), neighbours_(neighbours), chart_(charts.chart), edges_at_(mesh.positions.size(), 0) {
    for (std::uint32_t h = 0; h < neighbours.size(); ++h) {
      if (!is_border(h)) continue;
      // Counted once: by the chart with the lower number.
      if (chart_[h / 3] < other_chart(h)) ++edges_at_[start(h)], ++edges_at_[end(h)];
    }
  }
  bool is_border(std::uint32_t h) const {
    return chart_[h / 3] != kNoChart && (neighbours_[h] == kNoTriangle || other_chart(h) != chart_[h / 3]);
  }
  std::uint32_t other_chart(std::uint32_t h) const {
    return neighbours_[h] == kNoTriangle ? kNoChart : chart_[neighbours_[h]];
  }
  std::uint32_t start(std::uint32_t h) const { return mesh_.triangles[h / 3][h % 3]; }
  std::uint32_t end(std::uint32_t h) const { return mesh_.triangles[h / 3][(h % 3 + 1) % 3]; }
  bool is_node(std::uint32_t vertex) const { return edges_at_[vertex] != 2; }
  std::uint32_t chart(std::uint32_t h) const { return chart_[h / 3]; }
  bool is_open(std::uint32_t h) const { return neighbours_[h] == kNoTriangle; }

  /// The border half-edge of the same chart that starts where `h` ends: round the vertex inside the chart.
  std::uint32_t next(std::uint32_t h) const {
    std::uint32_t k = 3 * (h / 3) + (h % 3 + 1) % 3;
    while (!is_border(k)) {
      const std::uint32_t t = neighbours_[k], vertex = start(k);
      std::uint32_t corner = 0;
      while (mesh_.triangles[t][corner] != vertex) ++corner;
      k = 3 * t + corner;
    }
    return k;
  }

 private:
  const Mesh& mesh_;
  const std::vector<std::uint32_t>& neighbours_;
  const std::vector<std::uint32_t>& chart_;
  std::vector<std::uint32_t> edges_at_;
};

std::vector<std::uint32_t> run_from(const Border& border, std::uint32_t h, std::vector<std::uint8_t>& seen) {
  std::vector<std::uint32_t> vertices{border.start(h)};
  const std::uint32_t first = h;
  do {
    seen[h] = 1;
    vertices.push_back(border.end(h));
    if (border.is_node(border.end(h))) break;
    h = border.next(h);
  } while (h != first);
  return vertices;
}

}  // namespace

VertexCharts charts_around(const Mesh& mesh, const std::vector<std::uint32_t>& chart) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;
  pairs.reserve(3 * chart.size());
  for (std::size_t t = 0; t < chart.size(); ++t)
    for (const std::uint32_t v : mesh.triangles[t]) pairs.emplace_back(v, chart[t]);
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  VertexCharts around;
  around.first.assign(mesh.positions.size() + 1, 0);
  for (const auto& [vertex, of] : pairs) {
    ++around.first[vertex + 1];
    around.charts.push_back(of);
  }
  for (std::size_t v = 0; v + 1 < around.first.size(); ++v) around.first[v + 1] += around.first[v];
  return around;
}

Borders borders_of(const Mesh& mesh, const std::vector<std::uint32_t>& neighbours, const Charts& charts) {
  const Border border(mesh, neighbours, charts);
  Borders found;
  const auto halves = static_cast<std::uint32_t>(neighbours.size());
  std::vector<std::uint8_t> seen(halves, 0);
  auto add = [&](std::uint32_t h) {
    Arc arc;
    arc.left = border.chart(h);
    arc.right = border.other_chart(h);
    arc.open = border.is_open(h);
    arc.vertices = run_from(border, h, seen);
    found.arcs.push_back(std::move(arc));
  };
  // The chart with the lower number runs an arc between two charts; first those that begin at a node, then rings.
  auto runs = [&](std::uint32_t h) {
    return border.is_border(h) && border.chart(h) < border.other_chart(h) && !seen[h];
  };
  for (std::uint32_t h = 0; h < halves; ++h)
    if (runs(h) && border.is_node(border.start(h))) add(h);
  for (std::uint32_t h = 0; h < halves; ++h)
    if (runs(h)) add(h);

  found.loops.resize(charts.axis.size());
  std::fill(seen.begin(), seen.end(), 0);
  for (std::uint32_t h = 0; h < halves; ++h) {
    if (!border.is_border(h) || seen[h]) continue;
    std::vector<std::uint32_t> loop;
    for (std::uint32_t k = h; !seen[k]; k = border.next(k)) {
      seen[k] = 1;
      loop.push_back(border.start(k));
    }
    std::rotate(loop.begin(), std::min_element(loop.begin(), loop.end()), loop.end());
    found.loops[border.chart(h)].push_back(std::move(loop));
  }
  return found;
}

}  // namespace scanmill::surfaces
