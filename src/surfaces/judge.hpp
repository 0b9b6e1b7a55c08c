// SPDX-License-Identifier: Apache-2.0
// What stays out of tolerance: samples off the trimmed surfaces, borders at which surfaces stay apart.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "base/context.hpp"
#include "surfaces/meeting.hpp"
#include "surfaces/surfaces.hpp"

namespace scanmill::surfaces {

/// Charts at the corners of a triangle, ascending.
struct Candidates {
  std::array<std::uint32_t, 12> charts{};
  std::size_t count = 0;
};
Candidates candidates_of(const Mesh& mesh, const VertexCharts& around, std::uint32_t triangle);

struct Trimmed {
  const Mesh& mesh;
  const Charts& charts;
  const VertexCharts& around;
  const Borders& borders;
  const std::vector<ChartFit>& fits;
  const Samples& samples;
  const std::vector<std::uint32_t>& sample_chart;
  const std::vector<Vec3>& places;                  // of vertices
  const std::vector<std::uint8_t>& keep;            // vertices of polylines
  const std::vector<std::vector<TrimLoop>>& loops;  // per chart; none: no simple ones were found
  FitTerms terms;
};

/// Every triangle within `rings` rings of a vertex.
std::vector<std::uint8_t> triangles_around(const Mesh& mesh, std::vector<std::uint8_t> vertices, int rings);

struct Judgement {
  std::vector<std::uint8_t> cut;     // per triangle: must not be part of its chart
  std::vector<std::uint8_t> faulty;  // per chart: has such triangles
  std::vector<std::uint64_t> samples;
  std::vector<double> max_mm, sum2;
  double gap_mm = 0;
};

/// A chart without loops is cut whole.
/// distance  per sample: measured anew where `fresh` says so of its triangle, else as it is
/// cost      fresh samples near borders times sides of their charts' loops
Judgement judge_charts(const Trimmed& trimmed, const std::vector<std::uint8_t>& fresh, std::vector<double>& distance,
                       const Context& context);

}  // namespace scanmill::surfaces
