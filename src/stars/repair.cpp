// SPDX-License-Identifier: Apache-2.0
// What is still open is re-meshed loop by loop, each as a transaction: kept only if it leaves fewer open edges plus
// unused points than it found. So completion can only improve, and it ends.
#include <algorithm>

#include "stars/complete.hpp"

namespace scanmill::stars {
namespace {

constexpr int kFrontPasses = 12;
constexpr double kFoldWithSectors = -0.5, kFoldEarly = -0.8, kFoldLate = -0.97;
constexpr double kCostEarly = 15, kCostLate = 80;  // greatest fill cost of a front triangle, levels 0-1 and 2-3

using Half = std::pair<std::uint32_t, std::uint32_t>;

struct FrontChoice {
  double cost;
  Triangle t;
};

/// Missing half-edges at the vertices, ascending, and which vertices they end at.
std::vector<Half> open_halves(const Site& site, const std::vector<std::uint32_t>& vertices,
                              std::vector<std::uint32_t>& ends) {
  std::vector<Half> open;
  for (const std::uint32_t v : vertices) {
    if (!site.complex.is_open(v)) continue;
    for (const std::uint32_t t : site.complex.fan(v)) {
      const Triangle& x = site.complex.triangle(t);
      for (std::size_t e = 0; e < 3; ++e) {
        const std::uint32_t a = x[e], b = x[(e + 1) % 3];
        if ((a != v && b != v) || site.complex.half(b, a) != kNone) continue;
        open.push_back({b, a});
        ends.push_back(a);
        ends.push_back(b);
      }
    }
  }
  std::sort(open.begin(), open.end());
  open.erase(std::unique(open.begin(), open.end()), open.end());
  std::sort(ends.begin(), ends.end());
  ends.erase(std::unique(ends.begin(), ends.end()), ends.end());
  return open;
}

/// A front triangle also pays for the fold over each edge it shares.
double front_cost(const Site& site, const Triangle& t) {
  double cost = fill_cost(site, t);
  const Vec3 n = site.normal_of(t);
  for (std::size_t e = 0; e < 3; ++e) {
    const std::uint32_t k = site.complex.half(t[(e + 1) % 3], t[e]);
    if (k == kNone) continue;
    const double d = dot(n, site.normal_of(site.complex.triangle(k)));
    cost += 0.5 * (1 - d) + (d < -0.2 ? 3 : 0);
  }
  return cost;
}

void add_unique(std::vector<std::uint32_t>& sorted, std::vector<std::uint32_t>& more) {
  sorted.insert(sorted.end(), more.begin(), more.end());
  std::sort(sorted.begin(), sorted.end());
  sorted.erase(std::unique(sorted.begin(), sorted.end()), sorted.end());
}

/// Triangles to free at this level, ascending.
std::vector<std::uint32_t> doubtful(const Site& site, const std::vector<std::uint32_t>& zone, int level) {
  std::vector<std::uint32_t> list;
  auto in_zone = [&](std::uint32_t v) { return std::binary_search(zone.begin(), zone.end(), v); };
  for (const std::uint32_t v : zone)
    for (const std::uint32_t t : site.complex.fan(v)) {
      const Triangle& x = site.complex.triangle(t);
      const int corners = in_zone(x[0]) + in_zone(x[1]) + in_zone(x[2]);
      if ((level >= 1 && site.complex.votes(t) < 3) || (level >= 2 && corners >= 2) || level >= 3) list.push_back(t);
    }
  std::sort(list.begin(), list.end());
  list.erase(std::unique(list.begin(), list.end()), list.end());
  return list;
}

}  // namespace

void fill_front(Site& site, const std::vector<std::uint32_t>& vertices, double greatest_cost, bool with_sectors) {
  for (int pass = 0; pass < kFrontPasses; ++pass) {
    std::vector<std::uint32_t> ends;
    const std::vector<Half> open = open_halves(site, vertices, ends);
    std::vector<FrontChoice> choices;
    for (const auto& [p, q] : open) {
      for (const std::uint32_t w : site.in_range_of(p)) {
        if (w == q || !site.complex.kept(w)) continue;
        if (!site.complex.fan(w).empty() && !std::binary_search(ends.begin(), ends.end(), w)) continue;
        const Triangle t{p, q, w};
        if (!site.within_limits(t)) continue;
        const double cost = front_cost(site, t);
        if (cost < greatest_cost) choices.push_back({cost, t});
      }
    }
    std::sort(choices.begin(), choices.end(), [](const FrontChoice& x, const FrontChoice& y) {
      return x.cost != y.cost ? x.cost < y.cost : x.t < y.t;
    });
    std::size_t added = 0;
    for (const FrontChoice& choice : choices) {
      const Triangle& t = choice.t;
      if (!site.complex.edges_free(t) || (with_sectors && !site.sectors_free(t)) ||
          !site.fold_free(t, with_sectors ? kFoldWithSectors : site.fill_fold) || site.crossing_of(t) != kNone)
        continue;
      site.complex.add(t, 0);
      ++added;
    }
    if (added == 0) return;
  }
}

bool repair_loop(Site& site, const Loop& loop, int level, Report& report, std::vector<std::uint32_t>& changed) {
  for (std::size_t i = 0; i < loop.size(); ++i)  // an earlier repair may have changed it
    if (site.complex.half(loop[i], loop[(i + 1) % loop.size()]) != kNone || site.complex.fan(loop[i]).empty())
      return false;
  ++report.repairs_tried;
  const std::int64_t before = site.complex.open_edges() + site.complex.unused();
  std::vector<std::uint32_t> zone(loop);
  std::sort(zone.begin(), zone.end());
  zone.erase(std::unique(zone.begin(), zone.end()), zone.end());
  std::vector<std::uint32_t> ring = zone, more;
  site.complex.begin();
  site.turned_normals.clear();
  for (const std::uint32_t t : doubtful(site, zone, level)) {
    for (const std::uint32_t v : site.complex.triangle(t)) more.push_back(v);
    site.complex.remove(t);
  }
  std::vector<std::int32_t> near;
  for (const std::uint32_t v : zone) site.around(v, 1, near);
  for (const std::int32_t row : near) {
    const auto w = static_cast<std::uint32_t>(row);
    if (site.complex.kept(w) && site.complex.fan(w).empty()) more.push_back(w);
  }
  add_unique(ring, more);
  // The triangles that remain know the side better than a frame across a crease.
  std::vector<std::pair<std::uint32_t, Vec3>> old_normals;
  if (level >= 1)
    for (const std::uint32_t v : ring) {
      if (site.complex.fan(v).size() < 3) continue;
      Vec3 sum;
      for (const std::uint32_t t : site.complex.fan(v)) {
        const Triangle& x = site.complex.triangle(t);
        sum += cross(site.projected(x[1]) - site.projected(x[0]), site.projected(x[2]) - site.projected(x[0]));
      }
      if (!(norm2(sum) > 0)) continue;
      old_normals.push_back({v, site.normal[v]});
      site.normal[v] = unit(sum);
    }
  site.fill_fold = level < 2 ? kFoldEarly : kFoldLate;
  Report inner;
  if (level == 2) fill_loops(site, ring, inner);
  fill_front(site, ring, level < 2 ? kCostEarly : kCostLate, level < 2);
  std::size_t peeled = peel(site, ring);
  fill_loops(site, ring, inner);
  site.fill_fold = kFoldEarly;
  more.clear();
  for (const std::uint32_t t : site.complex.touched())
    for (const std::uint32_t v : site.complex.triangle(t)) more.push_back(v);
  add_unique(ring, more);
  while (const std::size_t again = peel(site, ring)) peeled += again;
  if (site.complex.open_edges() + site.complex.unused() < before) {
    for (const std::uint32_t t : site.complex.touched())
      for (const std::uint32_t v : site.complex.triangle(t)) changed.push_back(v);
    site.complex.keep();
    ++report.repairs_kept;
    report.points_revived += inner.points_revived;
    report.peeled += peeled;
    return true;
  }
  site.complex.undo();
  for (auto turned = site.turned_normals.rbegin(); turned != site.turned_normals.rend(); ++turned)
    site.normal[turned->first] = turned->second;
  for (const auto& [v, n] : old_normals) site.normal[v] = n;
  return false;
}

}  // namespace scanmill::stars
