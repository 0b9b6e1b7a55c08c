// SPDX-License-Identifier: Apache-2.0
#include "stars/vote.hpp"

#include <algorithm>
#include <numeric>

namespace scanmill::stars {
namespace {

constexpr std::size_t kGrain = 4096;
constexpr double kFlatness[4] = {0.95, 0.85, 0.7, 0.5};  // least |n.n'| of the links of each rank

/// Union-find that carries "same or opposite side" along each link.
class Sides {
 public:
  explicit Sides(std::size_t n) : up_(n), turned_(n, 0) { std::iota(up_.begin(), up_.end(), 0u); }
  struct Root {
    std::uint32_t row;
    bool turned;
  };
  Root root(std::uint32_t x) {
    std::uint32_t r = x;
    bool turned = false;
    while (up_[r] != r) {
      turned ^= turned_[r] != 0;
      r = up_[r];
    }
    bool rest = turned;
    while (up_[x] != r && x != r) {  // path compression keeps the parity
      const std::uint32_t next = up_[x];
      const bool step = turned_[x] != 0;
      up_[x] = r;
      turned_[x] = rest;
      rest ^= step;
      x = next;
    }
    return {r, turned};
  }
  /// False when a and b are already joined the other way.
  bool join(std::uint32_t a, std::uint32_t b, bool opposite) {
    Root p = root(a), q = root(b);
    if (p.row == q.row) return (p.turned != q.turned) == opposite;
    if (p.row > q.row) std::swap(p, q);
    up_[q.row] = p.row;
    turned_[q.row] = (p.turned != q.turned) != opposite;
    return true;
  }

 private:
  std::vector<std::uint32_t> up_;
  std::vector<std::uint8_t> turned_;
};

bool is_own(std::span<const Role> roles, std::size_t row) { return roles.empty() || roles[row] == Role::Own; }

void scan_stars(const SurfacePoints& points, const std::vector<Star>& stars, std::span<const Role> roles,
                double cos_min_angle, std::size_t begin, std::size_t end, Ballot& ballot) {
  for (std::size_t row = begin; row < end; ++row) {
    if (!is_own(roles, row)) continue;
    const Star& star = stars[row];
    const auto i = static_cast<std::uint32_t>(row);
    for (int k = 0; k < star.size; ++k) {
      if (star.gap(k)) continue;
      const std::uint32_t a = star.vertex[static_cast<std::size_t>(k)];
      const std::uint32_t b = star.vertex[static_cast<std::size_t>(k + 1 < star.size ? k + 1 : 0)];
      // Each triangle is looked at once: by the least of the corners that hold it; so lesser ones are asked first.
      const int in_lesser = a < b ? stars[a].direction(b, i) : stars[b].direction(i, a);
      if (in_lesser != 0 && std::min(a, b) < i) continue;
      const int in_greater = a < b ? stars[b].direction(i, a) : stars[a].direction(b, i);
      if (in_greater != 0 && std::max(a, b) < i) continue;
      const int in_a = a < b ? in_lesser : in_greater, in_b = a < b ? in_greater : in_lesser;
      auto radius = [&] { return circumradius(points.projected[i], points.projected[a], points.projected[b]); };
      if (in_a == 0 || in_b == 0) {
        ballot.candidates.push_back({{i, a, b}, 1 + (in_a != 0) + (in_b != 0), radius()});
        continue;
      }
      if (!angles_at_least(points.measured[i], points.measured[a], points.measured[b], cos_min_angle)) {
        ++ballot.refused.angle;
        ballot.candidates.push_back({{i, a, b}, 3, radius()});
        continue;
      }
      const Vec3 n = points.normal[i], na = points.normal[a], nb = points.normal[b];
      const double flat = std::min({std::abs(dot(n, na)), std::abs(dot(na, nb)), std::abs(dot(n, nb))});
      std::uint8_t rank = 0;
      while (rank < 4 && flat <= kFlatness[rank]) ++rank;
      ballot.agreed.push_back({{i, a, b}, in_a < 0, in_b < 0, rank});
    }
  }
}

/// visit(i, q) for all star neighbours of own rows.
template <class Visit>
void for_each_neighbour(const std::vector<Star>& stars, std::span<const Role> roles, Visit visit) {
  for (std::uint32_t i = 0; i < stars.size(); ++i) {
    if (!is_own(roles, i)) continue;
    for (int k = 0; k < stars[i].size; ++k) visit(i, stars[i].vertex[static_cast<std::size_t>(k)]);
  }
}

struct ComponentLink {
  std::uint32_t a, b;
  std::int64_t score;  // sum of n.n' in 2^-20: exact, so the order of adding does not matter
};

/// Joins what the triangles left apart by the largest summed agreement.
void join_components(std::vector<ComponentLink> links, Sides& sides) {
  using Link = ComponentLink;
  auto same_pair = [](const Link& x, const Link& y) { return x.a == y.a && x.b == y.b; };
  std::sort(links.begin(), links.end(),
            [](const Link& x, const Link& y) { return x.a != y.a ? x.a < y.a : x.b < y.b; });
  std::size_t pairs = 0;
  for (const Link& link : links) {
    if (pairs > 0 && same_pair(links[pairs - 1], link))
      links[pairs - 1].score += link.score;
    else
      links[pairs++] = link;
  }
  links.resize(pairs);
  std::sort(links.begin(), links.end(), [](const Link& x, const Link& y) {
    const std::int64_t p = std::abs(x.score), q = std::abs(y.score);
    if (p != q) return p > q;
    return x.a != y.a ? x.a < y.a : x.b < y.b;
  });
  for (const Link& link : links) sides.join(link.a, link.b, link.score < 0);
}

/// Per row: must its normal be turned. Components with a majority of views against them are turned as a whole.
std::vector<std::uint8_t> turns(const SurfacePoints& points, Sides& sides, std::vector<std::uint8_t>& sign_known) {
  const std::size_t n = points.bins.size();
  std::vector<std::int64_t> balance(n, 0);
  for (std::uint32_t row = 0; row < n; ++row) {
    const auto root = sides.root(row);
    if (points.kept[row] && points.sign_known[row]) balance[root.row] += root.turned ? -1 : 1;
  }
  std::vector<std::uint8_t> turn(n);
  sign_known.resize(n);
  for (std::uint32_t row = 0; row < n; ++row) {
    const auto root = sides.root(row);
    turn[row] = root.turned != (balance[root.row] < 0);
    sign_known[row] = balance[root.row] != 0;
  }
  return turn;
}

/// Ascending; by first corner into place, a handful each.
void sort_triangles(std::vector<Triangle>& triangles, std::size_t rows) {
  std::vector<std::uint32_t> next(rows + 1, 0);
  for (const Triangle& t : triangles) ++next[t[0] + 1];
  std::partial_sum(next.begin(), next.end(), next.begin());
  std::vector<Triangle> sorted(triangles.size());
  for (const Triangle& t : triangles) {
    std::uint32_t at = next[t[0]]++;
    for (; at > 0 && t < sorted[at - 1]; --at) sorted[at] = sorted[at - 1];
    sorted[at] = t;
  }
  triangles.swap(sorted);
}

Triangle oriented(Triangle t, bool turned) {
  if (turned) std::swap(t[1], t[2]);
  return t;
}

}  // namespace

double circumradius(Vec3 a, Vec3 b, Vec3 c) {
  const Vec3 u = b - a, v = c - a;
  const double area2 = norm(cross(u, v));
  return area2 > 0 ? norm(u) * norm(v) * norm(c - b) / (2 * area2) : 1e30;
}

std::vector<Ballot> ballots_of(const SurfacePoints& points, const std::vector<Star>& stars, std::span<const Role> roles,
                               double cos_min_angle, const Context& context) {
  const std::size_t n = points.bins.size();
  std::vector<Ballot> ballots((n + kGrain - 1) / kGrain);
  for_each_piece(context, n, kGrain, [&](std::size_t begin, std::size_t end, std::size_t piece, int) {
    scan_stars(points, stars, roles, cos_min_angle, begin, end, ballots[piece]);
  });
  return ballots;
}

std::vector<std::array<std::uint32_t, 2>> links_of(const std::vector<Star>& stars, std::span<const Role> roles,
                                                   const std::vector<Ballot>& ballots) {
  Sides sides(stars.size());
  // The vote joins the first two corners of every triangle; the third only where these did not contradict each other.
  for (const Ballot& ballot : ballots)
    for (const Agreed& t : ballot.agreed) sides.join(t.corners[0], t.corners[1], false);
  std::vector<std::array<std::uint32_t, 2>> links;
  for_each_neighbour(stars, roles, [&](std::uint32_t i, std::uint32_t q) {
    if (sides.root(i).row != sides.root(q).row) links.push_back({i, q});
  });
  return links;
}

Vote count_votes(const SurfacePoints& points, const std::vector<Ballot>& ballots, const std::vector<Star>* stars) {
  const std::size_t n = points.bins.size();
  Vote vote;
  Sides sides(n);
  std::vector<Triangle> unoriented;
  for (std::uint8_t rank = 0; rank < 5; ++rank)
    for (const Ballot& ballot : ballots)
      for (const Agreed& t : ballot.agreed) {
        if (t.rank != rank) continue;
        const auto [i, a, b] = t.corners;
        if (sides.join(i, a, t.a_opposite != 0) && sides.join(i, b, t.b_opposite != 0))
          unoriented.push_back(t.corners);
        else
          vote.candidates.push_back(
              {t.corners, 3, circumradius(points.projected[i], points.projected[a], points.projected[b])});
      }
  for (const Ballot& ballot : ballots)
    vote.candidates.insert(vote.candidates.end(), ballot.candidates.begin(), ballot.candidates.end());
  std::vector<ComponentLink> links;
  const auto add_link = [&](std::uint32_t i, std::uint32_t q) {
    const auto p = sides.root(i), r = sides.root(q);
    if (p.row == r.row) return;
    const double agreement = dot(points.normal[i], points.normal[q]) * (p.turned != r.turned ? -1 : 1);
    const auto score = static_cast<std::int64_t>(agreement * 0x1p20);
    links.push_back({std::min(p.row, r.row), std::max(p.row, r.row), score});
  };
  if (stars) for_each_neighbour(*stars, {}, add_link);
  for (const Ballot& ballot : ballots)
    for (const auto& [i, q] : ballot.links) add_link(i, q);
  join_components(std::move(links), sides);
  const std::vector<std::uint8_t> turn = turns(points, sides, vote.sign_known);
  vote.normal.assign(points.normal.begin(), points.normal.end());
  for (std::size_t row = 0; row < n; ++row)
    if (turn[row]) vote.normal[row] = -vote.normal[row];
  // A star runs counter-clockwise about the normal as given; a corner whose normal was turned sees its triangles
  // turned.
  vote.confirmed.reserve(unoriented.size());
  for (const Triangle& t : unoriented) vote.confirmed.push_back(oriented(t, turn[t[0]]));
  sort_triangles(vote.confirmed, n);
  for (Candidate& c : vote.candidates) c.corners = oriented(c.corners, turn[c.corners[0]]);
  std::sort(vote.candidates.begin(), vote.candidates.end(), [](const Candidate& x, const Candidate& y) {
    if (x.votes != y.votes) return x.votes > y.votes;
    if (x.radius != y.radius) return x.radius < y.radius;
    return x.corners < y.corners;
  });
  return vote;
}

}  // namespace scanmill::stars
