// SPDX-License-Identifier: Apache-2.0
// Where charts meet: border vertices, the arcs they form, and the loops around each chart.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "mesh/mesh.hpp"
#include "surfaces/charts.hpp"

namespace scanmill::surfaces {

/// Lists of charts, by vertex.
struct VertexCharts {
  std::vector<std::uint32_t> first, charts;  // first: one more than vertices; charts ascending, kNoChart last
  std::span<const std::uint32_t> of(std::uint32_t vertex) const {
    return std::span(charts).subspan(first[vertex], first[vertex + 1] - first[vertex]);
  }
};
VertexCharts charts_around(const Mesh& mesh, const std::vector<std::uint32_t>& chart);

/// A run of border edges between two vertices where more than two charts meet; or a ring, its first vertex again last.
struct Arc {
  std::vector<std::uint32_t> vertices;
  std::uint32_t left = kNoChart, right = kNoChart;  // seen along the run; kNoChart: facets or an open border
  bool open = false;                                // along an open edge of the mesh
};

struct Borders {
  std::vector<Arc> arcs;
  std::vector<std::vector<std::vector<std::uint32_t>>>
      loops;  // per chart: closed walks over vertices, chart on the left
};

/// Every chart has one fan at each vertex. Arcs by their first edge (least triangle, corner); loops start at their
/// least vertex.
Borders borders_of(const Mesh& mesh, const std::vector<std::uint32_t>& neighbours, const Charts& charts);

}  // namespace scanmill::surfaces
