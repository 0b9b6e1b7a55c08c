// SPDX-License-Identifier: Apache-2.0
// Geometry in integers of 128 bits: nothing rounds, so signs are what they are. Coordinates up to 2^24.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "geom/vec3.hpp"

namespace scanmill::exact {

__extension__ using Int = __int128;
struct Point {
  Int x = 0, y = 0, z = 0;
  friend bool operator==(const Point&, const Point&) = default;
};
inline Point operator-(Point a, Point b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Point operator+(Point a, Point b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Point operator*(Point a, Int s) { return {a.x * s, a.y * s, a.z * s}; }
inline Int dot(Point a, Point b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Point cross(Point a, Point b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
inline int sign(Int a) { return a > 0 ? 1 : a < 0 ? -1 : 0; }
inline Vec3 to_vec3(Point p) { return {static_cast<double>(p.x), static_cast<double>(p.y), static_cast<double>(p.z)}; }

inline int orientation(Point a, Point b, Point c, Point d) { return sign(dot(cross(b - a, c - a), d - a)); }

/// Closed convex hulls of two small sets of points share a point: no axis separates them. The axes tried are complete
/// for segments and triangles in space, flat ones included.
inline bool hulls_meet(std::span<const Point> a, std::span<const Point> b) {
  std::vector<Point> edges, axes;
  for (const auto set : {a, b})
    for (std::size_t i = 0; i < set.size(); ++i)
      for (std::size_t j = i + 1; j < set.size(); ++j) edges.push_back(set[j] - set[i]);
  for (std::size_t i = 0; i < edges.size(); ++i)
    for (std::size_t j = i + 1; j < edges.size(); ++j) axes.push_back(cross(edges[i], edges[j]));
  const std::size_t normals = axes.size();
  for (std::size_t n = 0; n < normals; ++n)  // within a common plane
    for (const Point& edge : edges) axes.push_back(cross(axes[n], edge));
  axes.insert(axes.end(), edges.begin(), edges.end());
  for (const Point& axis : axes) {
    Int low[2] = {}, high[2] = {};
    int which = 0;
    for (const auto set : {a, b}) {
      low[which] = high[which] = dot(axis, set[0]);
      for (const Point& p : set) {
        low[which] = std::min(low[which], dot(axis, p));
        high[which] = std::max(high[which], dot(axis, p));
      }
      ++which;
    }
    if (high[0] < low[1] || high[1] < low[0]) return false;
  }
  return true;
}

inline bool has_area(std::span<const Point> t) { return cross(t[1] - t[0], t[2] - t[0]) != Point{}; }

}  // namespace scanmill::exact
