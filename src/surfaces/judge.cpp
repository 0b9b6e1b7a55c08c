// SPDX-License-Identifier: Apache-2.0
#include "surfaces/judge.hpp"

#include <algorithm>
#include <cmath>

namespace scanmill::surfaces {
namespace {

double distance_to_loops(const std::vector<TrimLoop>& loops, Vec3 p) {
  double least2 = 1e300;
  for (const TrimLoop& loop : loops)
    for (std::size_t i = 0, j = loop.places.size() - 1; i < loop.places.size(); j = i++) {
      const Vec3 d = loop.places[i] - loop.places[j];
      const double length2 = norm2(d);
      const double t = length2 > 0 ? std::clamp(dot(p - loop.places[j], d) / length2, 0.0, 1.0) : 0;
      least2 = std::min(least2, norm2(p - loop.places[j] - d * t));
    }
  return std::sqrt(least2);
}

/// Triangles within two rings of a chart's border.
std::vector<std::uint8_t> near_borders(const Trimmed& on) {
  std::vector<std::uint8_t> vertex(on.mesh.positions.size(), 0);
  for (const Arc& arc : on.borders.arcs)
    for (const std::uint32_t v : arc.vertices) vertex[v] = 1;
  return triangles_around(on.mesh, std::move(vertex), 2);
}

double distance_in(const Trimmed& on, std::uint32_t chart, Vec3 p) {
  const HeightField::Foot foot = on.fits[chart].foot(p);
  if (inside(on.loops[chart], {foot.local.x, foot.local.y})) return foot.distance;
  return std::max(foot.distance, distance_to_loops(on.loops[chart], p));
}

/// From the sample to the nearest trimmed surface around it.
double distance_of(const Trimmed& on, std::uint32_t sample, bool near) {
  const Vec3 p = on.samples.places[sample];
  const std::uint32_t own = on.sample_chart[sample];
  if (!near) return on.fits[own].foot(p).distance;
  double least = on.loops[own].empty() ? 1e300 : distance_in(on, own, p);
  const Candidates others = candidates_of(on.mesh, on.around, on.samples.triangle[sample]);
  for (std::size_t k = 0; k < others.count; ++k) {
    const std::uint32_t c = others.charts[k];
    if (c != own && !on.loops[c].empty() && least > 0.2 * on.terms.tolerance_mm)
      least = std::min(least, distance_in(on, c, p));
  }
  return least;
}

/// Along the polylines: how far the surfaces on both sides, or surface and facets, are apart.
void judge_borders(const Trimmed& on, std::vector<std::uint8_t>& bad_vertex, double& gap_mm) {
  auto apart = [&](const Arc& arc, Vec3 p) {
    auto place = [&](std::uint32_t c) {
      const Vec3 q = on.fits[c].frame.local(p);
      return on.fits[c].frame.place({q.x, q.y, on.fits[c].field.at(q.x, q.y).z});
    };
    return norm(place(arc.left) - (arc.right == kNoChart ? p : place(arc.right)));
  };
  for (const Arc& arc : on.borders.arcs) {
    if (arc.open) continue;
    if (on.loops[arc.left].empty() || (arc.right != kNoChart && on.loops[arc.right].empty())) continue;
    std::size_t begin = 0;
    for (std::size_t k = 1; k < arc.vertices.size(); ++k) {
      if (!on.keep[arc.vertices[k]]) continue;
      const Vec3 a = on.places[arc.vertices[begin]], b = on.places[arc.vertices[k]];
      double worst = 0;
      for (const double share : {0.0, 0.25, 0.5, 0.75, 1.0}) worst = std::max(worst, apart(arc, a + (b - a) * share));
      if (worst > on.terms.tolerance_mm)
        for (std::size_t v = begin; v <= k; ++v) bad_vertex[arc.vertices[v]] = 1;
      else
        gap_mm = std::max(gap_mm, worst);
      begin = k;
    }
  }
}

}  // namespace

std::vector<std::uint8_t> triangles_around(const Mesh& mesh, std::vector<std::uint8_t> vertices, int rings) {
  std::vector<std::uint8_t> triangle(mesh.triangles.size(), 0);
  for (int ring = 0; ring < rings; ++ring) {
    for (std::size_t t = 0; t < triangle.size(); ++t)
      for (const std::uint32_t v : mesh.triangles[t]) triangle[t] |= vertices[v];
    for (std::size_t t = 0; t < triangle.size(); ++t)
      if (triangle[t])
        for (const std::uint32_t v : mesh.triangles[t]) vertices[v] = 1;
  }
  return triangle;
}

Candidates candidates_of(const Mesh& mesh, const VertexCharts& around, std::uint32_t triangle) {
  Candidates found;
  for (const std::uint32_t v : mesh.triangles[triangle])
    for (const std::uint32_t c : around.of(v)) {
      const auto end = found.charts.begin() + static_cast<std::ptrdiff_t>(found.count);
      if (c != kNoChart && found.count < found.charts.size() && std::find(found.charts.begin(), end, c) == end)
        found.charts[found.count++] = c;
    }
  std::sort(found.charts.begin(), found.charts.begin() + static_cast<std::ptrdiff_t>(found.count));
  return found;
}

Judgement judge_charts(const Trimmed& on, const std::vector<std::uint8_t>& fresh, std::vector<double>& distance,
                       const Context& context) {
  const std::size_t charts = on.charts.axis.size();
  Judgement found;
  found.cut.assign(on.mesh.triangles.size(), 0);
  found.faulty.assign(charts, 0);
  found.samples.assign(charts, 0);
  found.max_mm.assign(charts, 0);
  found.sum2.assign(charts, 0);
  const std::vector<std::uint8_t> near = near_borders(on);
  for_each_range(context, distance.size(), 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t s = begin; s < end; ++s)
      if (on.sample_chart[s] != kNoChart && fresh[on.samples.triangle[s]])
        distance[s] = distance_of(on, static_cast<std::uint32_t>(s), near[on.samples.triangle[s]] != 0);
  });
  for (std::size_t s = 0; s < distance.size(); ++s) {
    const std::uint32_t t = on.samples.triangle[s], c = on.charts.chart[t];
    if (c == kNoChart || on.sample_chart[s] == kNoChart) continue;
    if (distance[s] > on.terms.tolerance_mm) {
      found.cut[t] = 1;
      continue;
    }
    ++found.samples[c];
    found.max_mm[c] = std::max(found.max_mm[c], distance[s]);
    found.sum2[c] += distance[s] * distance[s];
  }
  std::vector<std::uint8_t> bad(on.mesh.positions.size(), 0);
  judge_borders(on, bad, found.gap_mm);
  for (std::size_t t = 0; t < found.cut.size(); ++t) {
    const std::uint32_t c = on.charts.chart[t];
    if (c == kNoChart) {
      found.cut[t] = 0;
      continue;
    }
    for (const std::uint32_t v : on.mesh.triangles[t]) found.cut[t] |= bad[v];
    if (on.loops[c].empty()) found.cut[t] = 1;
    found.faulty[c] |= found.cut[t];
  }
  return found;
}

}  // namespace scanmill::surfaces
