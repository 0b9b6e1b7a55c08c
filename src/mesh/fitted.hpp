// SPDX-License-Identifier: Apache-2.0
// Smooth surfaces in place of triangles: plain values that the stage `surfaces` fills and writers write.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "geom/cubic.hpp"
#include "geom/vec3.hpp"
#include "mesh/section.hpp"

namespace scanmill {

/// A tensor-product cubic B-spline, polynomial; parameters are mm on the chart's plane. The normal of increasing u and
/// v points outward. Frame of the mesh: offset not added.
struct SplineSurface {
  CubicSpans u, v;
  std::vector<Vec3> poles;  // u fastest
};

/// A closed polyline on a surface, with the surface on its left; the first place is not repeated. A place and its
/// parameters are the same to a thousandth of the bin edge.
struct TrimLoop {
  std::vector<Vec3> places;
  std::vector<Uv> parameters;
};

struct FittedChart {
  SplineSurface surface;
  std::vector<TrimLoop> loops;           // the outer one first, then holes
  std::vector<std::uint32_t> triangles;  // that it stands for, ascending
  double area_mm2 = 0;                   // of these
  std::uint64_t samples = 0;
  double max_mm = 0, rms_mm = 0;  // distances of its samples
};

struct FittedSurfaces {
  std::vector<FittedChart> charts;           // by least triangle
  std::vector<std::uint32_t> facets;         // triangles that no chart stands for, ascending
  std::vector<std::array<Vec3, 3>> corners;  // of these; drawn to the surfaces where they touch a chart
  double tolerance_mm = 0, quantum_mm = 0;   // quantum: what coordinates are multiples of, a power of ten
  double fitted_area_mm2 = 0, area_mm2 = 0;
  double max_mm = 0, rms_mm = 0;  // over all charts
  double gap_mm = 0;              // greatest between charts, and between charts and facets, along their borders
  std::uint64_t samples = 0, samples_left_out = 0;  // of samples: judged; left out: beyond open borders or off the mesh
};

}  // namespace scanmill
