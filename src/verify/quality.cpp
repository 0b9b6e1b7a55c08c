// SPDX-License-Identifier: Apache-2.0
// Counts by the definitions a user's other tools have, so that they can be compared: edges by vertex rows, components
// by shared vertices, percentiles by rank.
#include "verify/quality.hpp"

#include <algorithm>

#include "base/text.hpp"
#include "geom/angles.hpp"
#include "mesh/groups.hpp"
#include "verify/crossings.hpp"
#include "verify/edges.hpp"

namespace scanmill::verify {
namespace {

constexpr double kZeroArea2 = 1e-14;
constexpr std::size_t kCrossingsListed = 100, kGrain = 16384;
constexpr double kGreatestFloat = 3.4028234663852886e38;

/// Value of rank floor(q (n - 1)); reorders.
double percentile(std::vector<double>& values, double q) {
  if (values.empty()) return 0;
  const auto rank = static_cast<std::ptrdiff_t>(q * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + rank, values.end());
  return values[static_cast<std::size_t>(rank)];
}

/// The smallest angle lies across the shortest side.
double least_angle(const Vec3 (&at)[3], const double (&length2)[3]) {
  int shortest = 0;
  for (int k = 1; k < 3; ++k)
    if (length2[k] < length2[shortest]) shortest = k;
  const Vec3 apex = at[(shortest + 2) % 3];
  return degrees_between(at[shortest] - apex, at[(shortest + 1) % 3] - apex);
}

void measure_triangles(const Mesh& mesh, Quality& quality, std::vector<double>& area, const Context& context) {
  const std::size_t count = mesh.triangles.size();
  std::vector<double> angle(count), side(3 * count);
  area.resize(count);
  for_each_range(context, count, kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      const auto& [a, b, c] = mesh.triangles[t];
      const Vec3 at[3] = {mesh.positions[a], mesh.positions[b], mesh.positions[c]};
      const double length2[3] = {norm2(at[1] - at[0]), norm2(at[2] - at[1]), norm2(at[0] - at[2])};
      for (std::size_t k = 0; k < 3; ++k) side[3 * t + k] = std::sqrt(length2[k]);
      area[t] = norm(cross(at[1] - at[0], at[2] - at[0])) / 2;
      angle[t] = least_angle(at, length2);
    }
  });
  AngleFigures& angles = quality.angles;
  double sum = 0;
  for (std::size_t t = 0; t < count; ++t) {
    quality.area_mm2 += area[t];
    quality.zero_area_triangles += 2 * area[t] <= kZeroArea2;
    sum += angle[t];
    ++angles.histogram[std::min<std::size_t>(59, static_cast<std::size_t>(angle[t]))];
  }
  quality.volume_mm3 = signed_volume(mesh);
  angles.mean = count > 0 ? sum / static_cast<double>(count) : 0;
  angles.least = percentile(angle, 0);
  angles.p1 = percentile(angle, 0.01);
  angles.p5 = percentile(angle, 0.05);
  angles.p50 = percentile(angle, 0.5);
  quality.edges = {percentile(side, 0), percentile(side, 0.5), percentile(side, 0.99), percentile(side, 1)};
}

std::uint64_t duplicates_of(const Mesh& mesh) {
  std::vector<Triangle> sorted(mesh.triangles);
  for (Triangle& t : sorted) std::sort(t.begin(), t.end());
  std::sort(sorted.begin(), sorted.end());
  std::uint64_t count = 0;
  for (std::size_t i = 1; i < sorted.size(); ++i) count += sorted[i] == sorted[i - 1];
  return count;
}

/// Pieces by edges, and whether every triangle can be given a side: node 2 t stands for triangle t as it is, 2 t + 1
/// for it turned over; where both are joined there is no way.
void walk_edges(const Mesh& mesh, const Edges& edges, Quality& quality) {
  const auto count = static_cast<std::uint32_t>(mesh.triangles.size());
  Groups pieces(count), sides(2 * std::size_t{count});
  auto runs_up = [&](std::uint32_t corner) {
    const Triangle& t = mesh.triangles[corner / 3];
    return t[corner % 3] < t[(corner % 3 + 1) % 3];
  };
  for (std::size_t n = 0; n < edges.size(); ++n) {
    const auto corners = edges.at(n);
    for (const std::uint32_t c : corners) pieces.join(corners[0] / 3, c / 3);
    if (corners.size() != 2) continue;
    const std::uint32_t s = corners[0] / 3, t = corners[1] / 3, turned = runs_up(corners[0]) == runs_up(corners[1]);
    sides.join(2 * s, 2 * t + turned);
    sides.join(2 * s + 1, 2 * t + 1 - turned);
  }
  std::vector<std::uint32_t> size(count, 0);
  std::uint32_t largest = 0;
  for (std::uint32_t t = 0; t < count; ++t) {
    largest = std::max(largest, ++size[pieces.root(t)]);
    quality.edge_components += pieces.root(t) == t;
    quality.orientable = quality.orientable && sides.root(2 * t) != sides.root(2 * t + 1);
  }
  quality.largest_component_share = count > 0 ? static_cast<double>(largest) / static_cast<double>(count) : 0;
}

std::vector<Component> components_of(const Mesh& mesh, const std::vector<double>& area) {
  Groups groups(mesh.positions.size());
  std::vector<std::uint8_t> used(mesh.positions.size(), 0);
  for (const Triangle& t : mesh.triangles)
    for (const std::uint32_t v : t) {
      groups.join(t[0], v);
      used[v] = 1;
    }
  std::vector<std::uint32_t> number(mesh.positions.size(), 0);
  std::vector<Component> components;
  for (std::uint32_t v = 0; v < mesh.positions.size(); ++v) {
    if (!used[v]) continue;
    const std::uint32_t root = groups.root(v);
    if (root == v) {
      number[v] = static_cast<std::uint32_t>(components.size());
      components.emplace_back().first_vertex = v;
    }
    Component& component = components[number[root]];
    ++component.vertices;
    component.bounds.add(mesh.positions[v] + mesh.offset);
  }
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    Component& component = components[number[groups.root(mesh.triangles[t][0])]];
    ++component.triangles;
    component.area_mm2 += area[t];
  }
  std::stable_sort(components.begin(), components.end(),
                   [](const Component& a, const Component& b) { return a.triangles > b.triangles; });
  return components;
}

/// border_loops takes no triangle that names a vertex twice.
std::vector<BorderLoop> loops_of(const Mesh& mesh, std::uint64_t repeated_corners) {
  if (repeated_corners == 0) return border_loops(mesh);
  Mesh proper;
  proper.positions = mesh.positions;
  proper.offset = mesh.offset;
  for (const Triangle& t : mesh.triangles)
    if (!names_a_vertex_twice(t)) proper.triangles.push_back(t);
  return border_loops(proper);
}

Vec3 middle_of_overlap(const Mesh& mesh, std::uint32_t s, std::uint32_t t) {
  Bounds a, b;
  for (const std::uint32_t v : mesh.triangles[s]) a.add(mesh.positions[v]);
  for (const std::uint32_t v : mesh.triangles[t]) b.add(mesh.positions[v]);
  const Vec3 low{std::max(a.low.x, b.low.x), std::max(a.low.y, b.low.y), std::max(a.low.z, b.low.z)};
  const Vec3 high{std::min(a.high.x, b.high.x), std::min(a.high.y, b.high.y), std::min(a.high.z, b.high.z)};
  return low * 0.5 + high * 0.5 + mesh.offset;
}

void find_crossings(const Mesh& mesh, Quality& quality, const Context& context) {
  const CrossingPairs pairs = crossing_pairs(mesh, kCrossingsListed, context);
  quality.crossing_pairs = pairs.count;
  for (const auto& [s, t] : pairs.first) quality.crossings.push_back({s, t, middle_of_overlap(mesh, s, t)});
  for (const std::uint8_t crossed : pairs.crossed) quality.crossing_triangles += crossed;
}

}  // namespace

Result<void> check_mesh(const Mesh& mesh) {
  if (mesh.triangles.size() > kMostTriangles)
    return fail(Code::Unsupported, "the mesh has " + grouped(mesh.triangles.size()) + " triangles; at most " +
                                       grouped(kMostTriangles) + " can be judged at once");
  if (!mesh.patch.empty() && mesh.patch.size() != mesh.triangles.size())
    return fail(Code::BadInput, "the mesh names patches of " + grouped(mesh.patch.size()) + " triangles but has " +
                                    grouped(mesh.triangles.size()) + "; name one for each, or none");
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    const Vec3 p = mesh.positions[v];
    if (!is_finite(p) || std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}) > kGreatestFloat)
      return fail(Code::BadInput, "vertex " + std::to_string(v) + " of the mesh lies at (" + number_text(p.x) + ", " +
                                      number_text(p.y) + ", " + number_text(p.z) +
                                      "); coordinates must be finite and within float32");
  }
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (const std::uint32_t v : mesh.triangles[t])
      if (v >= mesh.positions.size())
        return fail(Code::BadInput, "triangle " + std::to_string(t) + " of the mesh names vertex " + std::to_string(v) +
                                        ", but there are only " + std::to_string(mesh.positions.size()));
  return {};
}

Result<Quality> quality_of(const Mesh& mesh, const Context& context) {
  TRY(check_mesh(mesh));
  Quality quality;
  quality.topology = topology_of(mesh);
  quality.vertices_unused = mesh.positions.size() - quality.topology.vertices_used;
  for (const Triangle& t : mesh.triangles) quality.repeated_corners += names_a_vertex_twice(t);
  quality.duplicate_triangles = duplicates_of(mesh);
  walk_edges(mesh, edges_of(mesh.positions.size(), mesh.triangles), quality);
  std::vector<double> area;
  measure_triangles(mesh, quality, area, context);
  quality.components = components_of(mesh, area);
  for (const Component& component : quality.components) quality.bounds.add(component.bounds);
  quality.loops = loops_of(mesh, quality.repeated_corners);
  find_crossings(mesh, quality, context);
  const TopologyCounts& counts = quality.topology;
  quality.closed_manifold = counts.triangles > 0 && counts.boundary_edges + counts.nonmanifold_edges +
                                                            counts.nonmanifold_vertices + quality.repeated_corners +
                                                            quality.duplicate_triangles ==
                                                        0;
  if (context.cancel.is_set()) return fail(Code::Cancelled, "stopped on request");
  return quality;
}

}  // namespace scanmill::verify
