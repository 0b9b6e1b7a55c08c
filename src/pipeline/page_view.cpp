// SPDX-License-Identifier: Apache-2.0
#include "pipeline/page_view.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "mesh/coarser.hpp"
#include "render/colours.hpp"
#include "render/render.hpp"

namespace scanmill::pipeline {
namespace {

using report::SurfaceView;

constexpr std::uint32_t kPatchColours = 30;

SurfaceView::Colour of(render::Rgb c) { return {c.r, c.g, c.b}; }

void add_colours(SurfaceView& view) {
  for (std::uint32_t n = 0; n < kPatchColours; ++n) view.patch_colours.push_back(of(render::patch_colour(n)));
  const render::ErrorScale scale;
  view.error_colours.push_back(of(render::kUnknown));
  for (std::size_t code = 1; code < report::kErrorColours; ++code)
    view.error_colours.push_back(of(scale.at(report::error_of_code(code))));
  view.front = of(render::kFront);
  view.back = of(render::kBack);
  view.open = of(render::kBoundary);
}

bool outweighs(double a, double b) {
  if (std::isnan(a) || std::isnan(b)) return std::isnan(b) && !std::isnan(a);
  return std::abs(a) != std::abs(b) ? std::abs(a) > std::abs(b) : a > b;
}

}  // namespace

report::SurfaceView view_of(const provenance::Record& record) {
  const Mesh& mesh = *record.mesh;
  const CoarserMesh coarse = coarser_mesh(mesh, kMostViewTriangles);
  SurfaceView view;
  view.full_triangles = mesh.triangles.size();
  view.cell_mm = coarse.cell_mm;
  for (const std::uint32_t v : coarse.row_of) view.positions.push_back(mesh.positions[v] + mesh.offset);
  view.triangles = coarse.triangles;
  if (!mesh.patch.empty())
    for (const std::uint32_t t : coarse.triangle) view.patch.push_back(mesh.patch[t]);
  if (record.vertex_error.size() == mesh.positions.size()) {
    view.errors.assign(coarse.row_of.size(), std::numeric_limits<double>::quiet_NaN());
    std::vector<double> errors(record.vertex_error.begin(), record.vertex_error.end());
    for (std::size_t v = 0; v < errors.size(); ++v)
      if (double& shown = view.errors[coarse.vertex[v]]; outweighs(errors[v], shown)) shown = errors[v];
    view.error_range_mm = render::automatic_error_range(errors);
  }
  for (const auto& [a, b] : open_edges(mesh)) {
    const auto edge = std::minmax({coarse.vertex[a], coarse.vertex[b]});
    if (edge.first != edge.second) view.open_edges.push_back(edge);
  }
  std::sort(view.open_edges.begin(), view.open_edges.end());
  view.open_edges.erase(std::unique(view.open_edges.begin(), view.open_edges.end()), view.open_edges.end());
  add_colours(view);
  return view;
}

}  // namespace scanmill::pipeline
