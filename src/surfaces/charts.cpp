// SPDX-License-Identifier: Apache-2.0
#include "surfaces/charts.hpp"

#include <algorithm>
#include <queue>
#include <tuple>

#include "mesh/groups.hpp"

namespace scanmill::surfaces {
namespace {

constexpr double kBend = 0.72;       // cosine of the bend a chart may have: less than half a right angle
constexpr double kFacing = 0.2;      // cosine at which a triangle cannot be part of a height field
constexpr double kBentBins = 6;      // bent area that asks for another seed, bin faces
constexpr double kReachBins = 30;    // distance from a proxy's centre that counts as much as ...
constexpr double kReachCost = 0.05;  // ... this much of |n - axis|^2
constexpr double kAlike = 0.9;       // cosine between the axes of charts that may be joined
constexpr double kFlat = 0.95;       // length of the mean normal of both together
constexpr double kNarrowBins = 0.9;  // area over border length
constexpr int kRounds = 12, kLastRounds = 3, kSettle = 4;

struct Proxy {
  Vec3 axis, centre;
  std::uint32_t seed = 0;
};

class Flood {
 public:
  Flood(const Mesh& mesh, const std::vector<std::uint32_t>& neighbours, const std::vector<Vec3>& normals, double bin_mm)
      : neighbours_(neighbours), normals_(normals), scale_(kReachCost / (kReachBins * kReachBins * bin_mm * bin_mm)) {
    for (const Triangle& t : mesh.triangles)
      centres_.push_back((mesh.positions[t[0]] + mesh.positions[t[1]] + mesh.positions[t[2]]) * (1.0 / 3));
    for (const Vec3& n : normals) units_.push_back(unit(n));
  }

  double cost(std::uint32_t t, const Proxy& proxy) const {
    return norm2(units_[t] - proxy.axis) + scale_ * norm2(centres_[t] - proxy.centre);
  }
  double facing(std::uint32_t t, const Proxy& proxy) const { return dot(units_[t], proxy.axis); }
  Proxy at(std::uint32_t t) const { return {units_[t], centres_[t], t}; }
  std::uint32_t size() const { return static_cast<std::uint32_t>(units_.size()); }

  /// Every triangle that a seed reaches gets the chart that reaches it at least cost.
  std::vector<std::uint32_t> run(const std::vector<Proxy>& proxies) const {
    using Offer = std::tuple<double, std::uint32_t, std::uint32_t>;  // cost, triangle, chart
    std::priority_queue<Offer, std::vector<Offer>, std::greater<>> offers;
    std::vector<std::uint32_t> chart(units_.size(), kNoChart);
    for (std::uint32_t c = 0; c < proxies.size(); ++c) offers.push({-1, proxies[c].seed, c});
    while (!offers.empty()) {
      const auto [cost_of, t, c] = offers.top();
      offers.pop();
      if (chart[t] != kNoChart) continue;
      chart[t] = c;
      for (std::size_t e = 0; e < 3; ++e) {
        const std::uint32_t other = neighbours_[3 * t + e];
        if (other != kNoTriangle && chart[other] == kNoChart && norm2(normals_[other]) > 0)
          offers.push({cost(other, proxies[c]), other, c});
      }
    }
    return chart;
  }

  void measure(const std::vector<std::uint32_t>& chart, std::vector<Proxy>& proxies) const {
    std::vector<Vec3> axis(proxies.size()), centre(proxies.size());
    std::vector<double> area(proxies.size(), 0);
    for (std::uint32_t t = 0; t < chart.size(); ++t) {
      if (chart[t] == kNoChart) continue;
      const double weight = norm(normals_[t]);
      axis[chart[t]] += normals_[t];
      centre[chart[t]] += centres_[t] * weight;
      area[chart[t]] += weight;
    }
    std::vector<double> least(proxies.size(), 1e300);
    for (std::size_t c = 0; c < proxies.size(); ++c)
      if (area[c] > 0) proxies[c].axis = unit(axis[c]), proxies[c].centre = centre[c] * (1 / area[c]);
    for (std::uint32_t t = 0; t < chart.size(); ++t) {
      if (chart[t] == kNoChart) continue;
      const double found = cost(t, proxies[chart[t]]);
      if (found < least[chart[t]]) least[chart[t]] = found, proxies[chart[t]].seed = t;
    }
  }

 private:
  const std::vector<std::uint32_t>& neighbours_;
  const std::vector<Vec3>& normals_;
  double scale_;
  std::vector<Vec3> centres_, units_;
};

/// The first triangle of each connected piece.
std::vector<Proxy> first_seeds(const Flood& flood, const std::vector<std::uint32_t>& neighbours,
                               const std::vector<Vec3>& normals) {
  Groups pieces(flood.size());
  for (std::uint32_t t = 0; t < flood.size(); ++t)
    for (std::size_t e = 0; e < 3; ++e) {
      const std::uint32_t other = neighbours[3 * t + e];
      if (other != kNoTriangle && norm2(normals[t]) > 0 && norm2(normals[other]) > 0) pieces.join(t, other);
    }
  std::vector<Proxy> proxies;
  for (std::uint32_t t = 0; t < flood.size(); ++t)
    if (pieces.root(t) == t && norm2(normals[t]) > 0) proxies.push_back(flood.at(t));
  return proxies;
}

/// Adds a seed at the most bent triangle of each chart that bends too far; tells whether there was one.
bool add_seeds(const Flood& flood, const std::vector<std::uint32_t>& chart, const std::vector<Vec3>& normals,
               double bin_mm, std::vector<Proxy>& proxies) {
  std::vector<double> bent(proxies.size(), 0), worst(proxies.size(), 2);
  std::vector<std::uint32_t> at(proxies.size(), kNoTriangle);
  for (std::uint32_t t = 0; t < chart.size(); ++t) {
    if (chart[t] == kNoChart) continue;
    const double facing = flood.facing(t, proxies[chart[t]]);
    if (facing < kBend) bent[chart[t]] += norm(normals[t]) / 2;
    if (facing < worst[chart[t]]) worst[chart[t]] = facing, at[chart[t]] = t;
  }
  const std::size_t before = proxies.size();
  for (std::size_t c = 0; c < before; ++c)
    if (bent[c] > kBentBins * bin_mm * bin_mm) proxies.push_back(flood.at(at[c]));
  return proxies.size() > before;
}

/// Joins neighbouring charts, the most alike first, as long as both together are nearly flat: more seeds may have been
/// needed on the way than are in the end.
void join_alike(const std::vector<std::uint32_t>& neighbours, const std::vector<Vec3>& normals,
                const std::vector<std::uint32_t>& chart, std::vector<Proxy>& proxies) {
  std::vector<Vec3> sum(proxies.size());
  std::vector<double> area(proxies.size(), 0);
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;
  for (std::uint32_t t = 0; t < chart.size(); ++t) {
    if (chart[t] == kNoChart) continue;
    sum[chart[t]] += normals[t];
    area[chart[t]] += norm(normals[t]);
    for (std::size_t e = 0; e < 3; ++e) {
      const std::uint32_t other = neighbours[3 * t + e];
      if (other != kNoTriangle && chart[other] != kNoChart && chart[other] > chart[t])
        pairs.emplace_back(chart[t], chart[other]);
    }
  }
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  Groups groups(proxies.size());
  for (;;) {
    double most = kAlike;
    std::pair<std::uint32_t, std::uint32_t> best{0, 0};
    for (const auto& [a, b] : pairs) {
      const std::uint32_t x = groups.root(a), y = groups.root(b);
      if (x == y) continue;
      const double alike = dot(unit(sum[x]), unit(sum[y]));
      if (alike > most && norm(sum[x] + sum[y]) > kFlat * (area[x] + area[y])) most = alike, best = {x, y};
    }
    if (best.first == best.second) break;
    const auto [x, y] = best;
    groups.join(x, y);
    const std::uint32_t root = groups.root(x), gone = root == x ? y : x;
    sum[root] += sum[gone];
    area[root] += area[gone];
    // The larger one's seed floods both.
    if (area[root] < 2 * area[gone]) proxies[root].seed = proxies[gone].seed;
    proxies[root].axis = unit(sum[root]);
  }
  std::vector<Proxy> left;
  for (std::uint32_t c = 0; c < proxies.size(); ++c)
    if (groups.root(c) == c && area[c] > 0) left.push_back(proxies[c]);
  proxies = std::move(left);
}

/// Takes the seeds of narrow charts away: a strip along a crease, whose triangles cut the crease off, stands for no
/// surface. Tells whether there was one.
bool drop_strips(const Mesh& mesh, const std::vector<std::uint32_t>& neighbours, const std::vector<Vec3>& normals,
                 const std::vector<std::uint32_t>& chart, double bin_mm, std::vector<Proxy>& proxies) {
  std::vector<double> area(proxies.size(), 0), border(proxies.size(), 0);
  std::vector<std::uint8_t> alone(proxies.size(), 1);
  for (std::uint32_t t = 0; t < chart.size(); ++t) {
    if (chart[t] == kNoChart) continue;
    area[chart[t]] += norm(normals[t]) / 2;
    for (std::size_t e = 0; e < 3; ++e) {
      const std::uint32_t other = neighbours[3 * t + e];
      if (other != kNoTriangle && chart[other] == chart[t]) continue;
      const Triangle& c = mesh.triangles[t];
      border[chart[t]] += norm(mesh.positions[c[(e + 1) % 3]] - mesh.positions[c[e]]);
      if (other != kNoTriangle && chart[other] != kNoChart) alone[chart[t]] = 0;
    }
  }
  std::vector<Proxy> left;
  for (std::size_t c = 0; c < proxies.size(); ++c)
    if (alone[c] || area[c] > kNarrowBins * bin_mm * border[c]) left.push_back(proxies[c]);
  const bool dropped = left.size() < proxies.size() && !left.empty();
  if (dropped) proxies = std::move(left);
  return dropped;
}

/// Pieces of charts by edges.
void part_pieces(const std::vector<std::uint32_t>& neighbours, std::vector<std::uint32_t>& chart) {
  Groups pieces(chart.size());
  for (std::uint32_t t = 0; t < chart.size(); ++t)
    for (std::size_t e = 0; e < 3; ++e) {
      const std::uint32_t other = neighbours[3 * t + e];
      if (other != kNoTriangle && chart[t] != kNoChart && chart[other] == chart[t]) pieces.join(t, other);
    }
  for (std::uint32_t t = 0; t < chart.size(); ++t)
    if (chart[t] != kNoChart) chart[t] = pieces.root(t);  // the piece's least triangle
}

/// Triangles of a second fan at a vertex get the chart number of a neighbour across an edge, or a new one.
bool part_fans(const Mesh& mesh, const std::vector<std::uint32_t>& neighbours, std::vector<std::uint32_t>& chart) {
  std::vector<std::uint32_t> order;
  for (std::uint32_t t = 0; t < chart.size(); ++t)
    if (chart[t] != kNoChart) order.push_back(t);
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return chart[a] < chart[b]; });
  std::vector<Triangle> members;
  std::vector<std::uint32_t> row(mesh.positions.size(), 0), dropped;
  for (std::size_t begin = 0; begin < order.size();) {
    std::size_t end = begin;
    members.clear();
    std::vector<std::uint32_t> vertices;
    for (; end < order.size() && chart[order[end]] == chart[order[begin]]; ++end) {
      const Triangle& t = mesh.triangles[order[end]];
      members.push_back(t);
      vertices.insert(vertices.end(), t.begin(), t.end());
    }
    std::sort(vertices.begin(), vertices.end());
    vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
    for (std::uint32_t v = 0; v < vertices.size(); ++v) row[vertices[v]] = v;
    for (Triangle& t : members)
      for (std::uint32_t& v : t) v = row[v];
    const std::vector<std::uint8_t> stays = single_fan_triangles(vertices.size(), members);
    for (std::size_t k = begin; k < end; ++k)
      if (!stays[k - begin]) dropped.push_back(order[k]);
    begin = end;
  }
  const std::vector<std::uint32_t> before = chart;
  for (const std::uint32_t t : dropped) {
    std::uint32_t taker = kNoChart;
    for (std::size_t e = 0; e < 3; ++e) {
      const std::uint32_t other = neighbours[3 * t + e];
      if (other != kNoTriangle && before[other] != before[t] && before[other] < taker) taker = before[other];
    }
    chart[t] = taker;  // none: a facet
  }
  return !dropped.empty();
}

}  // namespace

std::vector<std::uint32_t> opposite_triangles(const Mesh& mesh) {
  const std::vector<std::uint32_t> across = edge_neighbours(mesh.positions.size(), mesh.triangles);
  std::vector<std::uint32_t> opposite(across.size(), kNoTriangle);
  auto twice = [&](const Triangle& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; };
  for (std::uint32_t h = 0; h < across.size(); ++h) {
    const std::uint32_t other = across[h];
    if (other == kNoTriangle || other == h / 3) continue;
    const Triangle &t = mesh.triangles[h / 3], &o = mesh.triangles[other];
    if (twice(t) || twice(o)) continue;
    for (std::uint32_t e = 0; e < 3; ++e)
      if (o[e] == t[(h % 3 + 1) % 3] && o[(e + 1) % 3] == t[h % 3] && across[3 * other + e] == h / 3)
        opposite[h] = other;
  }
  return opposite;
}

std::vector<Vec3> area_normals(const Mesh& mesh) {
  std::vector<Vec3> normals;
  normals.reserve(mesh.triangles.size());
  for (const Triangle& t : mesh.triangles)
    normals.push_back(cross(mesh.positions[t[1]] - mesh.positions[t[0]], mesh.positions[t[2]] - mesh.positions[t[0]]));
  return normals;
}

void renumber_charts(const std::vector<Vec3>& normals, Charts& charts) {
  std::vector<std::uint32_t> number(charts.chart.size() + charts.axis.size() + 1, kNoChart);
  charts.axis.clear();
  for (std::uint32_t t = 0; t < charts.chart.size(); ++t) {
    std::uint32_t& chart = charts.chart[t];
    if (chart == kNoChart) continue;
    if (number[chart] == kNoChart) {
      number[chart] = static_cast<std::uint32_t>(charts.axis.size());
      charts.axis.push_back({});
    }
    chart = number[chart];
    charts.axis[chart] += normals[t];
  }
  for (Vec3& axis : charts.axis) axis = unit(axis);
}

void settle_charts(const Mesh& mesh, const std::vector<std::uint32_t>& neighbours, const std::vector<Vec3>& normals,
                   Charts& charts) {
  std::vector<std::uint32_t>& chart = charts.chart;
  for (int round = 0; round < kSettle; ++round) {
    part_pieces(neighbours, chart);
    if (!part_fans(mesh, neighbours, chart)) break;
  }
  drop_fans(mesh, neighbours, chart);
  for (int pass = 0;; ++pass) {
    renumber_charts(normals, charts);
    bool turned = false;
    for (std::uint32_t t = 0; t < chart.size(); ++t)
      if (chart[t] != kNoChart && dot(unit(normals[t]), charts.axis[chart[t]]) < kFacing)
        turned = true, chart[t] = kNoChart;
    if (!turned || pass == kSettle) break;
    drop_fans(mesh, neighbours, chart);
  }
  drop_fans(mesh, neighbours, chart);
  renumber_charts(normals, charts);
}

void drop_fans(const Mesh& mesh, const std::vector<std::uint32_t>& neighbours, std::vector<std::uint32_t>& chart) {
  for (bool changed = true; changed;) {
    part_pieces(neighbours, chart);
    const std::vector<std::uint32_t> before = chart;
    changed = part_fans(mesh, neighbours, chart);
    for (std::size_t t = 0; t < chart.size(); ++t)
      if (chart[t] != before[t]) chart[t] = kNoChart;
  }
}

Charts cut_into_charts(const Mesh& mesh, const std::vector<std::uint32_t>& neighbours, double bin_mm) {
  Charts charts;
  const std::vector<Vec3> normals = area_normals(mesh);
  const Flood flood(mesh, neighbours, normals, bin_mm);
  std::vector<Proxy> proxies = first_seeds(flood, neighbours, normals);
  charts.chart = flood.run(proxies);
  flood.measure(charts.chart, proxies);
  for (int round = 0; round < kRounds; ++round) {
    const bool more = add_seeds(flood, charts.chart, normals, bin_mm, proxies);
    for (int again = 0; again < 2; ++again) {
      charts.chart = flood.run(proxies);
      flood.measure(charts.chart, proxies);
    }
    if (!more) break;
  }
  join_alike(neighbours, normals, charts.chart, proxies);
  for (int round = 0; round < kRounds; ++round) {
    for (int again = 0; again < kLastRounds; ++again) {
      charts.chart = flood.run(proxies);
      flood.measure(charts.chart, proxies);
    }
    if (!drop_strips(mesh, neighbours, normals, charts.chart, bin_mm, proxies)) break;
  }
  settle_charts(mesh, neighbours, normals, charts);
  return charts;
}

}  // namespace scanmill::surfaces
