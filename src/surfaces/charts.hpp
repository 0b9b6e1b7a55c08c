// SPDX-License-Identifier: Apache-2.0
// A mesh cut into connected, nearly flat charts whose borders run along mesh edges.
#pragma once
#include <cstdint>
#include <vector>

#include "geom/vec3.hpp"
#include "mesh/mesh.hpp"

namespace scanmill::surfaces {

inline constexpr std::uint32_t kNoChart = 0xffffffffu;

struct Charts {
  std::vector<std::uint32_t> chart;  // per triangle; kNoChart: belongs to none
  std::vector<Vec3> axis;            // per chart: unit, every triangle's normal has a positive part along it
};

/// Triangles across edges (3 t + corner) that run the other way there, so that walks around vertices end; kNoTriangle
/// where there is none, several, one of the same direction or one that names a vertex twice.
std::vector<std::uint32_t> opposite_triangles(const Mesh& mesh);

/// Normals of the triangles, not of unit length: twice the area.
std::vector<Vec3> area_normals(const Mesh& mesh);

/// Planar proxies (normal and centre) flood the mesh from seeds, are measured and flood again; where a chart bends by
/// more than about 40 degrees over more than a few triangles it gets another seed. Pieces that hang together by a
/// vertex only are parted. Charts by least triangle. Triangles without area, and those that still face away from their
/// chart's axis, belong to none.
/// rule    costs, then triangle, then chart number decide; no dependence on threads
/// cost    O(F log F) per round, about 20 rounds
/// source  D. Cohen-Steiner, P. Alliez, M. Desbrun, Variational Shape Approximation (2004)
Charts cut_into_charts(const Mesh& mesh, const std::vector<std::uint32_t>& neighbours, double bin_mm);

/// Makes charts of what `charts` holds: each connected over edges, one fan at each vertex; what falls off a chart
/// becomes one of its own. Renumbers by least triangle and takes the axes anew.
void settle_charts(const Mesh& mesh, const std::vector<std::uint32_t>& neighbours, const std::vector<Vec3>& normals,
                   Charts& charts);

/// What hangs on a chart by a vertex only belongs to none any more; what has come apart gets different numbers: the
/// least triangle of each piece.
void drop_fans(const Mesh& mesh, const std::vector<std::uint32_t>& neighbours, std::vector<std::uint32_t>& chart);

/// Numbers by least triangle, and the axes anew.
void renumber_charts(const std::vector<Vec3>& normals, Charts& charts);

}  // namespace scanmill::surfaces
