// SPDX-License-Identifier: Apache-2.0
// Small loops: cheapest triangulation by dynamic programming over the loop (after G. Barequet and M. Sharir, "Filling
// gaps in the boundary of a polyhedron", CAGD 12, 1995), with measured vertices only and every triangle tested like any
// other.
#include <algorithm>
#include <set>

#include "stars/complete.hpp"

namespace scanmill::stars {
namespace {

constexpr std::size_t kLongestFilled = 60;  // edges
constexpr std::size_t kLongestFanned = 10;  // edges of a loop that may close around one point
constexpr int kPlans = 10;                  // triangulations tried before a loop is left
constexpr double kNever = 1e18;

/// Plan of a polygon's triangulation: middle[i][j] = k of the triangle (i, k, j).
struct Plan {
  std::size_t n;
  std::vector<double> cost;
  std::vector<int> middle;
  explicit Plan(std::size_t size) : n(size), cost(size * size, 0), middle(size * size, -1) {}
};

Plan cheapest_plan(const Site& site, const Loop& loop, const std::set<Triangle>& forbidden) {
  const std::size_t n = loop.size();
  Plan plan(n);
  for (std::size_t d = 2; d < n; ++d)
    for (std::size_t i = 0; i + d < n; ++i) {
      const std::size_t j = i + d;
      double& best = plan.cost[i * n + j];
      best = kNever;
      const std::uint32_t a = loop[i], b = loop[j];
      const bool last_edge = i == 0 && j == n - 1;
      if (!last_edge &&
          (a == b || !site.in_range(a, b) || site.complex.half(a, b) != kNone || site.complex.half(b, a) != kNone))
        continue;
      for (std::size_t k = i + 1; k < j; ++k) {
        const std::uint32_t c = loop[k];
        const double sides = plan.cost[i * n + k] + plan.cost[k * n + j];
        if (a == c || b == c || a == b || sides >= best) continue;
        const Triangle t{a, c, b};
        if (!site.within_limits(t) || (!forbidden.empty() && forbidden.count(t) != 0)) continue;
        const double total = sides + fill_cost(site, t);
        if (total < best) {
          best = total;
          plan.middle[i * n + j] = static_cast<int>(k);
        }
      }
    }
  return plan;
}

std::vector<Triangle> triangles_of(const Plan& plan, const Loop& loop) {
  std::vector<Triangle> list;
  std::vector<std::pair<std::size_t, std::size_t>> open{{0, plan.n - 1}};
  while (!open.empty()) {
    const auto [i, j] = open.back();
    open.pop_back();
    if (j - i < 2) continue;
    const auto k = static_cast<std::size_t>(plan.middle[i * plan.n + j]);
    list.push_back({loop[i], loop[k], loop[j]});
    open.push_back({i, k});
    open.push_back({k, j});
  }
  return list;
}

/// Adds all or none; the one that failed in `failed`.
bool add_all(Site& site, const std::vector<Triangle>& list, Triangle& failed) {
  std::vector<std::uint32_t> added;
  for (const Triangle& t : list) {
    if (!site.complex.edges_free(t) || !site.within_limits(t) || !site.fold_free(t, site.fill_fold) ||
        site.crossing_of(t) != kNone) {
      failed = t;
      for (const std::uint32_t number : added) site.complex.remove(number);
      return false;
    }
    added.push_back(site.complex.add(t, 0));
  }
  return true;
}

/// One more measured point inside a small loop, from the unused and thinned-out ones, joined to all its edges.
bool fill_around_point(Site& site, const Loop& loop, Report& report) {
  if (loop.size() > kLongestFanned) return false;
  Vec3 side;
  for (const std::uint32_t v : loop) side += site.normal[v];
  struct Choice {
    double sharpness;  // greatest cosine of a corner: the smaller the better
    std::uint32_t row;
  };
  std::vector<Choice> choices;
  for (const std::uint32_t c : site.in_range_of(loop.front())) {
    if (!site.points.usable[c] || !site.complex.fan(c).empty()) continue;
    const Vec3 n = dot(side, site.normal[c]) < 0 ? -site.normal[c] : site.normal[c];
    double sharpness = -1;
    bool fits = true;
    for (std::size_t i = 0; i < loop.size() && fits; ++i) {
      const Triangle t{loop[i], loop[(i + 1) % loop.size()], c};
      const Vec3 m = cross(site.projected(t[0]) - site.projected(c), site.projected(t[1]) - site.projected(c));
      fits = t[0] != c && t[1] != c && site.within_limits(t) && dot(m, n) > 0.1 * norm(m);
      for (std::size_t k = 0; k < 3 && fits; ++k) {
        const Vec3 u = site.measured(t[(k + 1) % 3]) - site.measured(t[k]),
                   w = site.measured(t[(k + 2) % 3]) - site.measured(t[k]);
        sharpness = std::max(sharpness, dot(u, w) / std::sqrt(norm2(u) * norm2(w)));
      }
    }
    if (fits) choices.push_back({sharpness, c});
  }
  std::sort(choices.begin(), choices.end(), [](const Choice& x, const Choice& y) {
    return x.sharpness != y.sharpness ? x.sharpness < y.sharpness : x.row < y.row;
  });
  for (const Choice& choice : choices) {
    const std::uint32_t c = choice.row;
    const Vec3 before = site.normal[c];
    if (dot(side, before) < 0) site.normal[c] = -before;
    std::vector<Triangle> list;
    for (std::size_t i = 0; i < loop.size(); ++i) list.push_back({loop[i], loop[(i + 1) % loop.size()], c});
    Triangle failed;
    if (add_all(site, list, failed)) {
      if (!site.complex.kept(c)) {
        site.complex.revive(c);
        ++report.points_revived;
      }
      site.turned_normals.push_back({c, before});
      ++report.loops_filled;
      report.triangles_filled += list.size();
      return true;
    }
    site.normal[c] = before;
  }
  return false;
}

}  // namespace

double fill_cost(const Site& site, const Triangle& t) {
  const Vec3 n = unit(cross(site.projected(t[1]) - site.projected(t[0]), site.projected(t[2]) - site.projected(t[0])));
  const double agreement = std::min({dot(n, site.normal[t[0]]), dot(n, site.normal[t[1]]), dot(n, site.normal[t[2]])});
  const double disagreement = agreement < 0 ? 60 : agreement < 0.2 ? 15 : 0;
  return circumradius(site.projected(t[0]), site.projected(t[1]), site.projected(t[2])) / site.h() * (2 - agreement) +
         disagreement;
}

bool fill_loop(Site& site, const Loop& loop, Report& report) {
  if (loop.size() < 3) return false;
  std::set<Triangle> forbidden;
  for (int attempt = 0; attempt < kPlans; ++attempt) {
    const Plan plan = cheapest_plan(site, loop, forbidden);
    if (plan.middle[loop.size() - 1] < 0) return fill_around_point(site, loop, report);
    const std::vector<Triangle> list = triangles_of(plan, loop);
    Triangle failed{};
    if (add_all(site, list, failed)) {
      ++report.loops_filled;
      report.triangles_filled += list.size();
      return true;
    }
    forbidden.insert(failed);
  }
  return false;
}

void fill_loops(Site& site, const std::vector<std::uint32_t>& vertices, Report& report, const Pace* pace) {
  const std::vector<Loop> loops = trace_loops(site, vertices, kLongestFilled);
  report.loops_found += loops.size();
  for (std::size_t n = 0; n < loops.size() && (pace == nullptr || pace->go_on(n, loops.size())); ++n) {
    const Loop& loop = loops[n];
    bool still_open = true;  // an earlier fill may have closed an edge of this loop
    for (std::size_t i = 0; i < loop.size() && still_open; ++i)
      still_open = site.complex.half(loop[i], loop[(i + 1) % loop.size()]) == kNone;
    if (still_open) fill_loop(site, loop, report);
  }
}

}  // namespace scanmill::stars
