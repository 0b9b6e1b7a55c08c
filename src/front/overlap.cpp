// SPDX-License-Identifier: Apache-2.0
#include "front/overlap.hpp"

#include <algorithm>

namespace scanmill::front {
namespace {

constexpr double kLikeNormals = 0.5;  // cosine of 60 degrees: steeper neighbours are a crease, not a second layer

struct Flat {
  double x, y;
};

double volume(Vec3 a, Vec3 b, Vec3 c, Vec3 d) { return dot(b - a, cross(c - a, d - a)); }

/// The segment passes through the inside of the triangle.
bool pierces(Vec3 p, Vec3 q, const std::array<Vec3, 3>& t) {
  const double above = volume(t[0], t[1], t[2], p), below = volume(t[0], t[1], t[2], q);
  if (!((above > 0 && below < 0) || (above < 0 && below > 0))) return false;
  const double u = volume(p, q, t[0], t[1]), v = volume(p, q, t[1], t[2]), w = volume(p, q, t[2], t[0]);
  return (u > 0 && v > 0 && w > 0) || (u < 0 && v < 0 && w < 0);
}

bool shares(const Facet& facet, std::uint32_t row) {
  return std::find(facet.rows.begin(), facet.rows.end(), row) != facet.rows.end();
}

/// An edge of a that touches no corner of b pierces b.
bool edge_pierces(const Facet& a, const Facet& b) {
  for (std::size_t e = 0; e < 3; ++e) {
    const std::size_t f = (e + 1) % 3;
    if (!shares(b, a.rows[e]) && !shares(b, a.rows[f]) && pierces(a.corners[e], a.corners[f], b.corners)) return true;
  }
  return false;
}

/// Some edge of `a` has all of `b` beyond it, but for the tolerance.
bool separated_by_edge_of(const std::array<Flat, 3>& a, const std::array<Flat, 3>& b, double tolerance) {
  for (std::size_t e = 0; e < 3; ++e) {
    const Flat p = a[e], q = a[(e + 1) % 3], r = a[(e + 2) % 3];
    Flat n{p.y - q.y, q.x - p.x};
    const double length = std::sqrt(n.x * n.x + n.y * n.y);
    if (!(length > 0)) continue;
    const double side = n.x * (r.x - p.x) + n.y * (r.y - p.y) >= 0 ? 1 / length : -1 / length;
    double deepest = -1e300;
    for (const Flat corner : b) deepest = std::max(deepest, side * (n.x * (corner.x - p.x) + n.y * (corner.y - p.y)));
    if (deepest <= tolerance) return true;
  }
  return false;
}

}  // namespace

bool overlap(const Facet& a, const Facet& b, double clearance, double tolerance) {
  if (edge_pierces(a, b) || edge_pierces(b, a)) return true;
  if (std::abs(dot(a.normal, b.normal)) < kLikeNormals) return false;
  const Vec3 origin = a.corners[0], across = unit(a.corners[1] - origin), up = cross(a.normal, across);
  std::array<Flat, 3> flat_a{}, flat_b{};
  double low = 1e300, high = -1e300;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3 p = a.corners[i] - origin, q = b.corners[i] - origin;
    flat_a[i] = {dot(p, across), dot(p, up)};
    flat_b[i] = {dot(q, across), dot(q, up)};
    const double height = dot(q, a.normal);
    low = std::min(low, height);
    high = std::max(high, height);
  }
  if (low > clearance || high < -clearance) return false;
  return !separated_by_edge_of(flat_a, flat_b, tolerance) && !separated_by_edge_of(flat_b, flat_a, tolerance);
}

}  // namespace scanmill::front
