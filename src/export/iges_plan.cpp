// SPDX-License-Identifier: Apache-2.0
#include "export/iges_plan.hpp"

#include <algorithm>

#include "base/text.hpp"

namespace scanmill::exporting {
namespace {

bool has_area(const Mesh& mesh, const Triangle& t) {
  const Vec3 n = cross(mesh.positions[t[1]] - mesh.positions[t[0]], mesh.positions[t[2]] - mesh.positions[t[0]]);
  return norm2(n) > 0;
}

void find_patches(IgesPlan& plan) {
  const Mesh& mesh = plan.mesh;
  std::vector<std::uint32_t> ids(mesh.patch.begin(), mesh.patch.end());
  std::sort(ids.begin(), ids.end());
  ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
  if (ids.empty()) ids.assign(1, 0);
  plan.patches.resize(ids.size());
  for (std::size_t i = 0; i < ids.size(); ++i) plan.patches[i] = {ids[i], "patch_" + std::to_string(ids[i]), {}};
  plan.patch_of.assign(mesh.triangles.size(), 0);
  for (std::size_t t = 0; t < mesh.patch.size(); ++t)
    plan.patch_of[t] =
        static_cast<std::uint32_t>(std::lower_bound(ids.begin(), ids.end(), mesh.patch[t]) - ids.begin());
}

Error overused(const IgesPlan& plan, const std::string& name) {
  const auto& [a, b] = plan.shells.edges[plan.shells.first_overused];
  const Vec3 middle = (plan.mesh.positions[a] + plan.mesh.positions[b]) * 0.5;
  return fail(Code::BadInput,
              counted(plan.shells.overused_edges, "edge") +
                  " with more than two triangles, or two in one direction, the first near " + number_text(middle.x) +
                  " " + number_text(middle.y) + " " + number_text(middle.z) +
                  "; style brep needs a manifold mesh: repair it, or write style trimmed, patches or wire",
              name);
}

Result<void> check_brep(const IgesPlan& plan, const std::string& name) {
  for (std::size_t t = 0; t < plan.mesh.triangles.size(); ++t)
    if (!plan.drawn[t])
      return fail(Code::BadInput,
                  counted(plan.left_out, "triangle") + " without area, the first is number " + grouped(t) +
                      "; style brep needs a plane for each: repair the mesh, or write style trimmed or patches, "
                      "which leave them out, or wire",
                  name);
  if (plan.shells.overused_edges > 0) return overused(plan, name);
  return {};
}

/// Which surfaces or lines each group holds.
void fill_groups(IgesPlan& plan) {
  std::uint64_t entity = plan.geometry();
  if (plan.options.style == IgesStyle::Patches)
    for (std::size_t t = 0; t < plan.mesh.triangles.size(); ++t)
      if (plan.drawn[t]) plan.patches[plan.patch_of[t]].members.push_back(entity++);
  if (plan.options.style == IgesStyle::Wire)
    for (const std::uint32_t triangle : plan.shells.first_triangle)
      plan.patches[plan.patch_of[triangle]].members.push_back(entity++);
}

/// A level, colour and name per chart, and for the facets.
void plan_surfaces(IgesPlan& plan) {
  const FittedSurfaces& fitted = *plan.options.surfaces;
  plan.patches.clear();
  plan.first_of_chart.assign(1, 0);
  for (std::uint32_t c = 0; c < fitted.charts.size(); ++c) {
    plan.patches.push_back({c, "surface_" + std::to_string(c), {}});
    plan.first_of_chart.push_back(plan.first_of_chart.back() + 2 + 3 * fitted.charts[c].loops.size());
  }
  plan.left_out = 0;
  plan.faces = fitted.charts.size() + fitted.corners.size();
  if (fitted.corners.empty()) return;
  plan.patches.push_back({static_cast<std::uint32_t>(fitted.charts.size()), "facets", {}});
  const std::uint64_t first = plan.chart(fitted.charts.size());
  for (std::uint64_t k = 0; k < fitted.corners.size(); ++k) plan.patches.back().members.push_back(first + k);
}

}  // namespace

Result<IgesPlan> iges_plan_of(const Mesh& mesh, const IgesOptions& options, const std::string& name) {
  if (mesh.triangles.empty()) return fail(Code::BadInput, "the mesh has no triangle to write", name);
  if (!mesh.patch.empty() && mesh.patch.size() != mesh.triangles.size())
    return fail(Code::Internal,
                grouped(mesh.triangles.size()) + " triangles have " + grouped(mesh.patch.size()) + " patch ids", name);
  if (options.style == IgesStyle::Surfaces && !options.surfaces)
    return fail(Code::Internal, "there are no fitted surfaces to write", name);
  IgesPlan plan{mesh, options, {}, {}, {}, {}, {}, {}, {}, {}};
  find_patches(plan);
  plan.drawn.reserve(mesh.triangles.size());
  for (const Triangle& t : mesh.triangles) plan.drawn.push_back(has_area(mesh, t));
  plan.faces = static_cast<std::uint64_t>(std::count(plan.drawn.begin(), plan.drawn.end(), 1));
  plan.left_out = mesh.triangles.size() - plan.faces;
  if (options.style == IgesStyle::Brep || options.style == IgesStyle::Wire) plan.shells = shells_of(mesh);
  if (options.style == IgesStyle::Brep) {
    TRY(check_brep(plan, name));
    plan.point_of.assign(mesh.positions.size(), 0);
    for (const Triangle& t : mesh.triangles) plan.point_of[t[0]] = 1;
    for (std::uint32_t v = 0; v < plan.point_of.size(); ++v)
      if (plan.point_of[v] != 0) {
        plan.point_of[v] = static_cast<std::uint32_t>(plan.point_rows.size());
        plan.point_rows.push_back(v);
      }
  }
  fill_groups(plan);
  if (options.style == IgesStyle::Surfaces) plan_surfaces(plan);
  return plan;
}

void iges_add_positions(IgesPlan& plan) {
  if (plan.options.style == IgesStyle::Surfaces) return;
  plan.position.reserve(plan.mesh.positions.size());
  for (const Vec3& p : plan.mesh.positions) plan.position.push_back({iges_real(p.x), iges_real(p.y), iges_real(p.z)});
}

std::uint64_t iges_entities_of(const IgesPlan& plan) {
  const std::uint64_t heads = 2 * plan.patches.size();
  switch (plan.options.style) {
    case IgesStyle::Brep: {
      std::uint64_t roots = 0;
      for (const Shell& shell : plan.shells.shells) roots += shell.closed && shell.volume_mm3 > 0 ? 2 : 1;
      return plan.roots() + roots;
    }
    case IgesStyle::Trimmed:
      return heads + 7 * plan.faces;
    case IgesStyle::Patches:
      return heads + plan.faces + plan.patches.size();
    case IgesStyle::Wire:
      return heads + plan.shells.edges.size() + plan.patches.size();
    case IgesStyle::Surfaces: {
      const std::uint64_t facets = plan.options.surfaces->corners.size();
      return heads + plan.first_of_chart.back() + facets + (facets > 0 ? 1 : 0);
    }
  }
  return 0;
}

IgesCounts iges_counts_of(const IgesPlan& plan) {
  IgesCounts counts;
  counts.left_out = plan.left_out;
  switch (plan.options.style) {
    case IgesStyle::Brep:
      counts.faces = plan.faces;
      counts.edges = plan.shells.edges.size();
      for (const Shell& shell : plan.shells.shells) {
        const bool solid = shell.closed && shell.volume_mm3 > 0;
        (solid ? counts.solids : counts.shells) += 1;
        if (shell.closed && !solid) ++counts.inside_out;
      }
      break;
    case IgesStyle::Trimmed:
      counts.faces = plan.faces;
      break;
    case IgesStyle::Patches:
      counts.faces = plan.faces;
      counts.groups = plan.patches.size();
      break;
    case IgesStyle::Wire:
      counts.edges = plan.shells.edges.size();
      counts.groups = plan.patches.size();
      counts.left_out = 0;
      break;
    case IgesStyle::Surfaces:
      counts.faces = plan.faces;
      counts.surfaces = plan.options.surfaces->charts.size();
      counts.groups = plan.options.surfaces->corners.empty() ? 0 : 1;
      break;
  }
  return counts;
}

}  // namespace scanmill::exporting
