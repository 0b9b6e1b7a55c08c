// SPDX-License-Identifier: Apache-2.0
// Where the surfaces of neighbouring charts meet.
#pragma once
#include <cstdint>
#include <vector>

#include "surfaces/borders.hpp"
#include "surfaces/chart_fit.hpp"

namespace scanmill::surfaces {

/// A place for each border vertex of the mesh (others stand where the mesh has them).
/// Inner arcs are smoothed along their run, every vertex is drawn to the mean of its feet on the surfaces around it:
/// where these cross, to their intersection. Arcs along facets are not smoothed. A vertex that would go farther than
/// 1.5 bins does not move. `held` per vertex: 1, not smoothed; 2, not moved. `smooth`: rounds with smoothing, before
/// others without.
std::vector<Vec3> meet(const Mesh& mesh, const Borders& borders, const VertexCharts& around,
                       const std::vector<ChartFit>& fits, const std::vector<std::uint8_t>& held, int smooth,
                       const FitTerms& terms);

/// Which vertices of the arcs a polyline needs to stay within `tolerance_mm` of all; nodes and vertices of facets
/// always stay, and of a loop three at least. source  D. Douglas, T. Peucker (1973)
std::vector<std::uint8_t> needed_vertices(const Borders& borders, const VertexCharts& around,
                                          const std::vector<Vec3>& places, double tolerance_mm);

/// No side of the loops meets another one, the first loop runs counter-clockwise around all others, these clockwise.
/// Puts the outer loop first. cost  O(sides^2)
bool sort_simple_loops(std::vector<TrimLoop>& loops);
bool inside(const std::vector<TrimLoop>& loops, Uv p);

}  // namespace scanmill::surfaces
