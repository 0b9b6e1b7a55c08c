// SPDX-License-Identifier: Apache-2.0
// The surface of an object as facets to be seen and samples that stand in the way.
#include <algorithm>
#include <cmath>
#include <limits>

#include "base/text.hpp"
#include "lattice/lattice.hpp"
#include "plan/propose.hpp"

namespace scanmill::plan {
namespace {

constexpr double kMostSamples = 2e7;

struct Sample {
  BinKey bin;
  int side = 0;  // the axis its normal is nearest to, and its sign
  Vec3 point, normal;
};

int side_of(Vec3 n) {
  const double x = std::abs(n.x), y = std::abs(n.y), z = std::abs(n.z);
  if (x >= y && x >= z) return n.x > 0 ? 0 : 1;
  if (y >= z) return n.y > 0 ? 2 : 3;
  return n.z > 0 ? 4 : 5;
}

bool stands_before(const Sample& a, const Sample& b) {
  if (!(a.bin == b.bin)) return before(a.bin, b.bin);
  if (a.side != b.side) return a.side < b.side;
  return before(a.point, b.point);
}

}  // namespace

Result<Surface> surface_of(const Mesh& mesh, double bin_mm) {
  Surface surface;
  surface.bin_mm = bin_mm;
  const double spacing = bin_mm / 2;
  const Lattice lattice{bin_mm, {}};
  double expected = 0;
  for (const Triangle& t : mesh.triangles)
    expected +=
        1 + norm(cross(mesh.positions[t[1]] - mesh.positions[t[0]], mesh.positions[t[2]] - mesh.positions[t[0]])) /
                (spacing * spacing);
  if (expected > kMostSamples)
    return fail(Code::BadParameter,
                "bins of " + number_text(bin_mm) + " mm are too small for this object; choose larger ones");
  std::vector<Sample> samples;
  for (const Triangle& t : mesh.triangles) {
    const Vec3 a = mesh.positions[t[0]] + mesh.offset, u = mesh.positions[t[1]] - mesh.positions[t[0]],
               v = mesh.positions[t[2]] - mesh.positions[t[0]];
    const Vec3 area = cross(u, v);
    if (!(norm2(area) > 0) || !is_finite(area)) continue;
    const Vec3 normal = unit(area);
    const double longest = std::sqrt(std::max({norm2(u), norm2(v), norm2(v - u)}));
    const int n = std::max(1, static_cast<int>(std::ceil(longest / spacing)));
    // Centres of n^2 equal triangles: those that stand upright, then those on their heads.
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n - i; ++j)
        for (const double shift : {1.0 / 3, 2.0 / 3}) {
          if (shift > 0.5 && j == n - i - 1) continue;
          const Vec3 p = a + u * ((i + shift) / n) + v * ((j + shift) / n);
          samples.push_back({bin_of(lattice, p), side_of(normal), p, normal});
        }
  }
  if (samples.empty()) return fail(Code::BadInput, "the mesh has no area; wanted faces");
  std::sort(samples.begin(), samples.end(), stands_before);
  for (std::size_t first = 0; first < samples.size();) {
    std::size_t end = first;
    Vec3 sum, normals;
    for (; end < samples.size() && samples[end].bin == samples[first].bin && samples[end].side == samples[first].side;
         ++end) {
      sum += samples[end].point;
      normals += samples[end].normal;
    }
    surface.facets.push_back({sum * (1 / static_cast<double>(end - first)), unit(normals)});
    first = end;
  }
  for (const Sample& sample : samples) surface.samples.push_back(sample.point);
  return surface;
}

Mesh mesh_of_box(const Box& box) {
  Mesh mesh;
  for (std::uint32_t k = 0; k < 8; ++k)
    mesh.positions.push_back(
        {k & 1 ? box.high.x : box.low.x, k & 2 ? box.high.y : box.low.y, k & 4 ? box.high.z : box.low.z});
  constexpr std::uint32_t kFaces[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                          {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  for (const auto& f : kFaces) {
    mesh.triangles.push_back({f[0], f[1], f[2]});
    mesh.triangles.push_back({f[0], f[2], f[3]});
  }
  return mesh;
}

std::vector<std::uint32_t> facets_seen(const Surface& surface, const Sensor& sensor, const Pose& view,
                                       double min_cosine) {
  constexpr int kMostCells = 400;
  const double extent = std::max(sensor.field_x_mm, sensor.field_y_mm);
  const int cells = std::clamp(static_cast<int>(extent / (surface.bin_mm * 0.6)), 16, kMostCells);
  const double cell_x = sensor.field_x_mm / cells, cell_y = sensor.field_y_mm / cells;
  const Pose to_sensor = view.inverse();
  const double far = sensor.stand_off_mm + sensor.depth_mm;
  /// Column and row of the field, and depth; depth < 0 outside.
  const auto seen_at = [&](Vec3 p, int& column, int& row) {
    const Vec3 q = to_sensor.apply(p);
    if (!(q.z > 0) || q.z > far + 4 * surface.bin_mm) return -1.0;
    const double scale = sensor.perspective ? sensor.stand_off_mm / q.z : 1;
    const double x = q.x * scale / cell_x + cells * 0.5, y = q.y * scale / cell_y + cells * 0.5;
    if (!(x >= 0 && x < cells && y >= 0 && y < cells)) return -1.0;
    column = static_cast<int>(x);
    row = static_cast<int>(y);
    return q.z;
  };
  std::vector<float> nearest(static_cast<std::size_t>(cells) * static_cast<std::size_t>(cells),
                             std::numeric_limits<float>::max());
  int column = 0, row = 0;
  for (const Vec3 p : surface.samples) {
    const double z = seen_at(p, column, row);
    if (z < 0) continue;
    float& there = nearest[static_cast<std::size_t>(row * cells + column)];
    there = std::min(there, static_cast<float>(z));
  }
  std::vector<std::uint32_t> seen;
  const double slack = 2 * surface.bin_mm;
  for (std::size_t f = 0; f < surface.facets.size(); ++f) {
    const Facet& facet = surface.facets[f];
    const Vec3 towards = sensor.perspective ? unit(view.translation - facet.point) : view.turn({0, 0, -1});
    if (dot(towards, facet.normal) < min_cosine) continue;
    const double z = seen_at(facet.point, column, row);
    if (z < sensor.stand_off_mm - sensor.depth_mm || z > far) continue;
    if (z > static_cast<double>(nearest[static_cast<std::size_t>(row * cells + column)]) + slack) continue;
    seen.push_back(static_cast<std::uint32_t>(f));
  }
  return seen;
}

}  // namespace scanmill::plan
