// SPDX-License-Identifier: Apache-2.0
#include "pipeline/surface.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "front/front.hpp"
#include "pipeline/no_surface.hpp"

namespace scanmill::pipeline {
namespace {

float to_float(double value) { return static_cast<float>(value); }

/// What either engine hands to merge.
struct Grown {
  std::vector<Triangle> triangles;       // rows
  std::vector<std::uint8_t> side_known;  // per row
  std::vector<std::uint32_t> patch;      // per triangle; engine front only
  std::vector<Vec3> seeds;               // engine front only, frame of the written points
};

Result<Grown> grow_by_stars(const reduce::ReducedCloud& cloud, const WrittenPoints& w, const What& what,
                            std::optional<std::vector<stars::Ballot>> ballots, const Context& context,
                            Progress& progress, MeshedSurface& out) {
  const stars::SurfacePoints points = surface_points(cloud, w);
  const stars::Params params = star_params(what);
  TRY_ASSIGN(stars::Surface surface, ballots
                                         ? stars::mesh_ballots(points, *std::move(ballots), params, context, progress)
                                         : stars::mesh_points(points, params, context, progress));
  out.stars = surface.report;
  out.refused = surface.report.refused;
  return Grown{std::move(surface.triangles), std::move(surface.sign_known), {}, {}};
}

Result<Grown> grow_by_front(const reduce::ReducedCloud& cloud, const WrittenPoints& w, const What& what, Vec3 offset,
                            const Context& context, MeshedSurface& out) {
  std::vector<std::uint32_t> rows;
  front::Input input;
  std::vector<Vec3> points, normals;
  for (std::uint32_t row = 0; row < cloud.size(); ++row) {
    if (!w.kept[row]) continue;
    rows.push_back(row);
    points.push_back(w.measured[row]);
    normals.push_back(cloud.normal[row]);
  }
  input.points = points;
  input.normals = normals;
  input.edge_mm = cloud.lattice.edge_mm;
  input.limits = what.grow;
  for (const Vec3 seed : what.seeds.points) input.seeds.push_back(seed - offset);
  TRY_ASSIGN(front::Output fronts, front::grow_fronts(input, context));
  Grown grown;
  for (const Triangle& t : fronts.triangles) grown.triangles.push_back({rows[t[0]], rows[t[1]], rows[t[2]]});
  grown.side_known.assign(cloud.size(), 0);
  grown.patch = std::move(fronts.patch);
  grown.seeds = std::move(fronts.seed_points);
  out.refused = fronts.refused;
  out.refused_overlap = fronts.refused_overlap;
  out.stars.kept = rows.size();
  return grown;
}

/// Counts, areas and border lengths of the patches of a mesh whose every triangle has one.
/// Patches as the front engine grew them, in the numbering of the merged mesh.
grow::Patches patches_of_fronts(const Mesh& mesh, const Grown& grown) {
  grow::Patches out;
  std::vector<std::uint32_t> number(grown.seeds.size(), kNoTriangle);
  for (std::uint32_t patch : mesh.patch) number[patch] = 0;
  for (std::size_t s = 0; s < number.size(); ++s) {
    if (number[s] == kNoTriangle) continue;
    number[s] = static_cast<std::uint32_t>(out.patches.size());
    out.patches.push_back({grown.seeds[s] + mesh.offset, grow::SeedOrigin::Given, 0, 0, 0});
  }
  for (const std::uint32_t patch : mesh.patch) out.patch.push_back(number[patch]);
  measure_patches(mesh, out);
  return out;
}

/// Ranks count from 0 again in each patch, in the same order.
void close_ranks(grow::Patches& patches) {
  std::vector<std::uint32_t> order(patches.rank.size()), next(patches.patches.size(), 0);
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return patches.rank[a] != patches.rank[b] ? patches.rank[a] < patches.rank[b] : a < b;
  });
  for (const std::uint32_t t : order) patches.rank[t] = next[patches.patch[t]]++;
}

/// Removes the triangles that no given seed reached (`cover: false`) and numbers the vertices again. Where that cuts a
/// vertex's fan in two, its largest fan stays.
void keep_reached(MeshedSurface& out) {
  std::vector<Triangle> reached;
  std::vector<std::uint32_t> at;
  for (std::uint32_t t = 0; t < out.mesh.triangles.size(); ++t) {
    if (out.patches.patch[t] == kNoTriangle) continue;
    reached.push_back(out.mesh.triangles[t]);
    at.push_back(t);
  }
  const auto stays = single_fan_triangles(out.mesh.positions.size(), reached);
  for (std::size_t k = 0; k < at.size(); ++k)
    if (!stays[k]) out.patches.patch[at[k]] = kNoTriangle;
  Mesh kept;
  kept.offset = out.mesh.offset;
  std::vector<std::uint32_t> vertex(out.mesh.positions.size(), kNoTriangle), rows, patch, rank;
  for (std::size_t t = 0; t < out.mesh.triangles.size(); ++t)
    if (out.patches.patch[t] != kNoTriangle)
      for (const std::uint32_t v : out.mesh.triangles[t]) vertex[v] = 0;
  for (std::size_t v = 0; v < vertex.size(); ++v) {
    if (vertex[v] == kNoTriangle) continue;
    vertex[v] = static_cast<std::uint32_t>(rows.size());
    rows.push_back(out.vertex_row[v]);
    kept.positions.push_back(out.mesh.positions[v]);
  }
  for (std::size_t t = 0; t < out.mesh.triangles.size(); ++t) {  // numbering keeps the order, so triangles stay sorted
    if (out.patches.patch[t] == kNoTriangle) continue;
    const Triangle& x = out.mesh.triangles[t];
    kept.triangles.push_back({vertex[x[0]], vertex[x[1]], vertex[x[2]]});
    patch.push_back(out.patches.patch[t]);
    rank.push_back(out.patches.rank[t]);
  }
  out.mesh = std::move(kept);
  out.vertex_row = std::move(rows);
  out.patches.patch = std::move(patch);
  out.patches.rank = std::move(rank);
  measure_patches(out.mesh, out.patches);
  close_ranks(out.patches);
}

}  // namespace

void measure_patches(const Mesh& mesh, grow::Patches& out) {
  for (grow::Patch& patch : out.patches) patch.triangles = 0, patch.area_mm2 = patch.border_mm = 0;
  const auto across = edge_neighbours(mesh.positions.size(), mesh.triangles);
  for (std::size_t c = 0; c < across.size(); ++c) {
    grow::Patch& patch = out.patches[out.patch[c / 3]];
    const Triangle& t = mesh.triangles[c / 3];
    const Vec3 a = mesh.positions[t[c % 3]], b = mesh.positions[t[(c % 3 + 1) % 3]];
    if (across[c] == kNoTriangle || out.patch[across[c]] != out.patch[c / 3]) patch.border_mm += norm(b - a);
    if (c % 3 != 0) continue;
    ++patch.triangles;
    patch.area_mm2 +=
        norm(cross(mesh.positions[t[1]] - mesh.positions[t[0]], mesh.positions[t[2]] - mesh.positions[t[0]])) / 2;
  }
}

WrittenPoints written_points(const reduce::ReducedCloud& cloud, Vec3 offset) {
  WrittenPoints w;
  const std::size_t n = cloud.size();
  w.measured.resize(n);
  w.projected.resize(n);
  w.kept.resize(n);
  w.usable.resize(n);
  for (std::size_t row = 0; row < n; ++row) {
    const Vec3 p = cloud.measured[row] - offset;
    w.measured[row] = {to_float(p.x) + 0.0f, to_float(p.y) + 0.0f, to_float(p.z) + 0.0f};  // + 0: no -0
    w.projected[row] = cloud.projected[row] - offset;
    w.kept[row] = cloud.drop[row] == reduce::Drop::Kept;
    w.usable[row] = w.kept[row] || cloud.drop[row] == reduce::Drop::NeighbourDistance;
  }
  return w;
}

stars::SurfacePoints surface_points(const reduce::ReducedCloud& cloud, const WrittenPoints& w) {
  return {cloud.lattice.edge_mm, cloud.base,   cloud.bins,       &cloud.index, w.measured,
          w.projected,           cloud.normal, cloud.sign_known, w.kept,       w.usable};
}

stars::Params star_params(const What& what) { return {what.grow.range_bins, what.grow.min_angle_deg}; }

Vec3 float32_offset(const Bounds& bounds, double edge_mm) {
  if (bounds.empty()) return {};
  const double largest = std::max({std::abs(bounds.low.x), std::abs(bounds.low.y), std::abs(bounds.low.z),
                                   std::abs(bounds.high.x), std::abs(bounds.high.y), std::abs(bounds.high.z)});
  const float at = to_float(largest);
  if (static_cast<double>(std::nextafter(at, 1e38f)) - static_cast<double>(at) <= edge_mm / 1000) return {};
  const double step = 1024 * edge_mm;
  auto middle = [&](double low, double high) { return std::floor((low + high) / 2 / step) * step; };
  return {middle(bounds.low.x, bounds.high.x), middle(bounds.low.y, bounds.high.y),
          middle(bounds.low.z, bounds.high.z)};
}

Result<MeshedSurface> mesh_surface(const reduce::ReducedCloud& cloud, const Bounds& bounds, const What& what,
                                   const Context& context, Progress& progress,
                                   std::optional<std::vector<stars::Ballot>> ballots) {
  MeshedSurface out;
  const Vec3 offset = float32_offset(bounds, cloud.lattice.edge_mm);
  const WrittenPoints w = written_points(cloud, offset);
  const bool by_front = what.grow.engine == Engine::Front;
  if (by_front) progress.stage("grow", 0, 0);
  TRY_ASSIGN(Grown grown, by_front ? grow_by_front(cloud, w, what, offset, context, out)
                                   : grow_by_stars(cloud, w, what, std::move(ballots), context, progress, out));
  progress.stage("merge", 0, 0);
  merge::Merged merged =
      merge::merge_components({w.measured, offset, grown.side_known, grown.triangles, grown.patch}, what.merge);
  if (merged.mesh.triangles.empty()) return fail(Code::BadInput, no_surface_text(cloud, what.lattice, out.stars.kept));
  out.mesh = std::move(merged.mesh);
  out.vertex_row = std::move(merged.vertex_row);
  out.strays = std::move(merged.strays);
  out.stray_rows = std::move(merged.stray_rows);
  out.components = merged.components;
  out.sides_by_volume = merged.turned_by_volume;
  for (const merge::Stray& stray : out.strays) out.kept_in_strays += stray.vertices;
  if (by_front) {
    out.patches = patches_of_fronts(out.mesh, grown);
  } else {
    progress.stage("grow", 0, 0);
    std::vector<float> variation(out.vertex_row.size());
    for (std::size_t v = 0; v < variation.size(); ++v) variation[v] = cloud.variation[out.vertex_row[v]];
    TRY_ASSIGN(out.patches,
               grow::grow_patches({cloud.lattice.edge_mm, out.mesh.positions, offset, variation, out.mesh.triangles,
                                   what.grow.normal_dot(), what.merge.min_patch_triangles},
                                  what.seeds, context));
    out.refused.normal = out.patches.refused_normal;
    if (!what.seeds.cover) keep_reached(out);
  }
  out.mesh.patch = out.patches.patch;
  out.borders = grow::patch_borders(out.mesh.triangles, out.mesh.patch, out.mesh.positions.size());
  out.loops = border_loops(out.mesh);
  for (const std::uint32_t row : out.vertex_row) out.kept_used += w.kept[row];
  return out;
}

}  // namespace scanmill::pipeline
