// SPDX-License-Identifier: Apache-2.0
#include "surfaces/meeting.hpp"

#include <algorithm>

namespace scanmill::surfaces {
namespace {

constexpr double kFarBins = 1.5;
constexpr int kDraw = 16;

double segment_distance2(Vec3 p, Vec3 a, Vec3 b) {
  const Vec3 d = b - a;
  const double length2 = norm2(d);
  const double t = length2 > 0 ? std::clamp(dot(p - a, d) / length2, 0.0, 1.0) : 0;
  return norm2(p - a - d * t);
}

bool at_facets(const VertexCharts& around, std::uint32_t vertex) {
  const auto charts = around.of(vertex);
  return !charts.empty() && charts.back() == kNoChart;
}

/// Keeps what Douglas and Peucker keep of run[begin .. end].
void keep_between(const std::vector<std::uint32_t>& run, std::size_t begin, std::size_t end,
                  const std::vector<Vec3>& places, double tolerance2, std::vector<std::uint8_t>& keep) {
  std::vector<std::pair<std::size_t, std::size_t>> open{{begin, end}};
  while (!open.empty()) {
    const auto [a, b] = open.back();
    open.pop_back();
    double farthest = tolerance2;
    std::size_t at = 0;
    for (std::size_t k = a + 1; k < b; ++k) {
      const double distance2 = segment_distance2(places[run[k]], places[run[a]], places[run[b]]);
      if (distance2 > farthest) farthest = distance2, at = k;
    }
    if (at == 0) continue;
    keep[run[at]] = 1;
    open.emplace_back(a, at);
    open.emplace_back(at, b);
  }
}

double turn(Uv a, Uv b, Uv c) { return (b.u - a.u) * (c.v - a.v) - (b.v - a.v) * (c.u - a.u); }

bool segments_meet(Uv a, Uv b, Uv c, Uv d) {
  if (std::max(a.u, b.u) < std::min(c.u, d.u) || std::max(c.u, d.u) < std::min(a.u, b.u)) return false;
  if (std::max(a.v, b.v) < std::min(c.v, d.v) || std::max(c.v, d.v) < std::min(a.v, b.v)) return false;
  const double s = turn(a, b, c), t = turn(a, b, d), x = turn(c, d, a), y = turn(c, d, b);
  return !((s > 0 && t > 0) || (s < 0 && t < 0) || (x > 0 && y > 0) || (x < 0 && y < 0));
}

double loop_area(const TrimLoop& loop) {
  double area = 0;
  const auto& p = loop.parameters;
  for (std::size_t i = 0, j = p.size() - 1; i < p.size(); j = i++) area += p[j].u * p[i].v - p[j].v * p[i].u;
  return area / 2;
}

}  // namespace

std::vector<Vec3> meet(const Mesh& mesh, const Borders& borders, const VertexCharts& around,
                       const std::vector<ChartFit>& fits, const std::vector<std::uint8_t>& held, int smooth,
                       const FitTerms& terms) {
  struct Place {
    std::uint32_t vertex, before, after;  // neighbours on an arc that may be smoothed; equal: none
  };
  std::vector<Place> moving;
  std::vector<std::uint8_t> seen(mesh.positions.size(), 0);
  for (const Arc& arc : borders.arcs)
    for (std::size_t k = 0; k < arc.vertices.size(); ++k) {
      const std::uint32_t v = arc.vertices[k];
      if (seen[v] || held[v] > 1) continue;
      seen[v] = 1;
      const bool within = k > 0 && k + 1 < arc.vertices.size() && !arc.open && held[v] == 0 && !at_facets(around, v);
      moving.push_back({v, within ? arc.vertices[k - 1] : v, within ? arc.vertices[k + 1] : v});
    }
  std::vector<Vec3> places = mesh.positions, next = places;
  for (int round = 0; round < smooth + kDraw; ++round) {
    for (const Place& m : moving) {
      Vec3 p = places[m.vertex];
      if (round < smooth) p = (places[m.before] + p * 2 + places[m.after]) * 0.25;
      Vec3 sum;
      double charts = 0;
      for (const std::uint32_t c : around.of(m.vertex))
        if (c != kNoChart) sum += fits[c].frame.place(fits[c].foot(p).local), ++charts;
      next[m.vertex] = sum * (1 / charts);
    }
    for (const Place& m : moving) places[m.vertex] = next[m.vertex];
  }
  const double far = kFarBins * terms.bin_mm;
  for (const Place& m : moving)
    if (norm2(places[m.vertex] - mesh.positions[m.vertex]) > far * far) places[m.vertex] = mesh.positions[m.vertex];
  return places;
}

std::vector<std::uint8_t> needed_vertices(const Borders& borders, const VertexCharts& around,
                                          const std::vector<Vec3>& places, double tolerance_mm) {
  std::vector<std::uint8_t> keep(places.size(), 0);
  const double tolerance2 = tolerance_mm * tolerance_mm;
  for (const Arc& arc : borders.arcs) {
    const std::vector<std::uint32_t>& run = arc.vertices;
    for (const std::uint32_t v : run)
      if (at_facets(around, v)) keep[v] = 1;
    keep[run.front()] = keep[run.back()] = 1;
    if (run.front() == run.back())  // of a ring also what lies farthest from its beginning
      keep[*std::max_element(run.begin(), run.end(), [&](std::uint32_t a, std::uint32_t b) {
        return norm2(places[a] - places[run[0]]) < norm2(places[b] - places[run[0]]);
      })] = 1;
    std::size_t begin = 0;
    for (std::size_t k = 1; k < run.size(); ++k)
      if (keep[run[k]]) keep_between(run, begin, k, places, tolerance2, keep), begin = k;
  }
  // Two charts may share two nodes and nothing between them but straight runs: a loop needs three corners.
  for (const auto& of_chart : borders.loops)
    for (const auto& loop : of_chart) {
      std::size_t kept = 0;
      for (const std::uint32_t v : loop) kept += keep[v];
      for (std::size_t k = 0; k < loop.size() && kept < 3; ++k) {
        const std::uint32_t v = loop[(2 * k + 1) * loop.size() / 6 % loop.size()];
        if (!keep[v]) keep[v] = 1, ++kept;
      }
    }
  return keep;
}

bool sort_simple_loops(std::vector<TrimLoop>& loops) {
  std::vector<std::pair<Uv, Uv>> sides;
  std::vector<std::size_t> loop_of, next_of;
  for (std::size_t l = 0; l < loops.size(); ++l) {
    const auto& p = loops[l].parameters;
    if (p.size() < 3) return false;
    const std::size_t begin = sides.size();
    for (std::size_t k = 0; k < p.size(); ++k) {
      if (p[k] == p[(k + 1) % p.size()]) return false;
      sides.emplace_back(p[k], p[(k + 1) % p.size()]);
      next_of.push_back(begin + (k + 1) % p.size());
    }
  }
  for (std::size_t a = 0; a < sides.size(); ++a)
    for (std::size_t b = a + 1; b < sides.size(); ++b) {
      if (next_of[a] == b || next_of[b] == a) {
        const auto& [p, q] = next_of[a] == b ? sides[a] : sides[b];
        const Uv r = next_of[a] == b ? sides[b].second : sides[a].second;
        // Neighbours share a corner; they must not fold back on each other.
        if (turn(p, q, r) == 0 && (p.u - q.u) * (r.u - q.u) + (p.v - q.v) * (r.v - q.v) > 0) return false;
        continue;
      }
      if (segments_meet(sides[a].first, sides[a].second, sides[b].first, sides[b].second)) return false;
    }
  std::size_t outer = loops.size();
  for (std::size_t l = 0; l < loops.size(); ++l)
    if (loop_area(loops[l]) > 0) {
      if (outer != loops.size()) return false;
      outer = l;
    }
  if (outer == loops.size()) return false;
  std::rotate(loops.begin(), loops.begin() + static_cast<std::ptrdiff_t>(outer),
              loops.begin() + static_cast<std::ptrdiff_t>(outer) + 1);
  for (std::size_t l = 1; l < loops.size(); ++l)
    if (!inside({loops[0]}, loops[l].parameters[0])) return false;
  return true;
}

bool inside(const std::vector<TrimLoop>& loops, Uv p) {
  bool in = false;
  for (const TrimLoop& loop : loops) {
    const auto& q = loop.parameters;
    for (std::size_t i = 0, j = q.size() - 1; i < q.size(); j = i++)
      if ((q[i].v > p.v) != (q[j].v > p.v) && p.u < (q[j].u - q[i].u) * (p.v - q[i].v) / (q[j].v - q[i].v) + q[i].u)
        in = !in;
  }
  return in;
}

}  // namespace scanmill::surfaces
