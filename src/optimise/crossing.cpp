// SPDX-License-Identifier: Apache-2.0
#include "optimise/crossing.hpp"

#include <algorithm>

#include "geom/predicates.hpp"

namespace scanmill::optimise {
namespace {

/// Planes around a tetrahedron whose projection along `up` is the convex quadrilateral a d b c: four through its sides,
/// four through its corners, a floor and a ceiling. Bit k of a code: strictly beyond plane k.
class Prism {
 public:
  Prism(const Surface& surface, const Quad& q) : surface_(surface), origin_(surface.at(q.c)) {
    known_.fill(kNone);
    const Vec3 a = surface.at(q.a), b = surface.at(q.b), d = surface.at(q.d);
    // Twice the mean normal of a quadrilateral is the cross product of its diagonals.
    up_ = unit(cross(b - a, origin_ - d));
    right_ = perpendicular(up_);
    ahead_ = cross(up_, right_);
    const Local corner[4] = {local(a), local(d), local(b), local(origin_)};
    low_ = high_ = 0;
    for (const Local& p : corner) {
      low_ = std::min(low_, p.z);
      high_ = std::max(high_, p.z);
    }
    const double size = norm(b - a) + norm(d - origin_);
    margin_ = 1e-9 * size;
    convex_ = true;
    for (std::size_t k = 0; k < 4; ++k) {
      const Local p = corner[k], r = corner[(k + 1) % 4];
      const double x = r.y - p.y, y = p.x - r.x, length = std::sqrt(x * x + y * y);
      if (!(length > 0)) {
        convex_ = false;
        return;
      }
      side_[k] = {x / length, y / length, 0};
      side_[k].level = side_[k].x * p.x + side_[k].y * p.y;
      for (const std::size_t other : {(k + 2) % 4, (k + 3) % 4})
        convex_ = convex_ && beyond(side_[k], corner[other]) < -margin_;
    }
    for (std::size_t k = 0; k < 4; ++k) {  // at corner k, between the sides k - 1 and k
      const Plane before = side_[(k + 3) % 4], after = side_[k];
      const double x = before.x + after.x, y = before.y + after.y, length = std::sqrt(x * x + y * y);
      corner_[k] = length > 1e-3 ? Plane{x / length, y / length, 0} : after;
      corner_[k].level = corner_[k].x * corner[k].x + corner_[k].y * corner[k].y;
    }
    const std::uint32_t ids[4] = {q.a, q.d, q.b, q.c};
    for (std::size_t k = 0; k < 4; ++k) {
      own_[k] = ids[k];
      own_code_[k] = static_cast<std::uint16_t>(1u << k | 1u << ((k + 3) % 4) | 16u << k);
    }
  }

  bool convex() const { return convex_; }

  struct Code {
    std::uint16_t planes;
    float distance;  // greatest over the planes: no point of the tetrahedron is nearer
  };

  /// Each vertex is worked out once.
  Code code(std::uint32_t v) {
    const std::uint32_t at = v % kMemory;
    if (known_[at] == v) return codes_[at];
    known_[at] = v;
    return codes_[at] = work_out(v);
  }

 private:
  struct Local {
    double x, y, z;
  };
  struct Plane {
    double x, y, level;
  };
  static constexpr std::uint32_t kMemory = 64;
  static double beyond(const Plane& plane, const Local& p) { return plane.x * p.x + plane.y * p.y - plane.level; }

  Local local(Vec3 p) const {
    const Vec3 r = p - origin_;
    return {dot(r, right_), dot(r, ahead_), dot(r, up_)};
  }

  Code work_out(std::uint32_t v) const {
    // The tetrahedron touches a plane at its own corners only: an edge from there that leaves across it stays clear.
    for (std::size_t k = 0; k < 4; ++k)
      if (own_[k] == v) return {own_code_[k], 0};
    const Local p = local(surface_.at(v));
    unsigned planes = 0;
    double farthest = 0;
    auto against = [&](double distance, unsigned bit) {
      planes |= static_cast<unsigned>(distance > margin_) << bit;
      farthest = std::max(farthest, distance);
    };
    for (unsigned k = 0; k < 4; ++k) against(beyond(side_[k], p), k);
    for (unsigned k = 0; k < 4; ++k) against(beyond(corner_[k], p), 4 + k);
    against(low_ - p.z, 8);
    against(p.z - high_, 9);
    return {static_cast<std::uint16_t>(planes), static_cast<float>(farthest)};
  }

  const Surface& surface_;
  Vec3 origin_, right_, ahead_, up_;
  Plane side_[4], corner_[4];
  double low_, high_, margin_;
  bool convex_;
  std::uint32_t own_[4];
  std::uint16_t own_code_[4];
  std::array<std::uint32_t, kMemory> known_;
  std::array<Code, kMemory> codes_;
};

}  // namespace

Obstacle CrossingGuard::judge(std::uint32_t self, std::span<const Winner> winners,
                              std::span<const std::uint32_t> winner_of, std::vector<std::uint32_t>& rivals) const {
  const Quad& q = winners[self].quad;
  // Around a vertex with several fans not every fan is kept up to date; and what meets there is no quadrilateral.
  if (surface_.is_split(q.a) || surface_.is_split(q.b) || surface_.is_split(q.c) || surface_.is_split(q.d))
    return Obstacle::EdgeExists;
  Prism prism(surface_, q);
  auto corners = [&](std::uint32_t i, std::uint32_t j, std::uint32_t k) {
    return Corners{{surface_.at(i), surface_.at(j), surface_.at(k)}, {i, j, k}};
  };
  auto meets_new = [&](const Corners& x) {
    return triangles_cross(corners(q.c, q.d, q.b), x) || triangles_cross(corners(q.d, q.c, q.a), x);
  };
  auto is_rival = [&](const Quad& r) {
    if ((r.c == q.c && r.d == q.d) || (r.c == q.d && r.d == q.c)) return true;
    if (prism.convex() &&
        (prism.code(r.a).planes & prism.code(r.b).planes & prism.code(r.c).planes & prism.code(r.d).planes) != 0)
      return false;
    return meets_new(corners(r.c, r.d, r.b)) || meets_new(corners(r.d, r.c, r.a));
  };
  auto crosses = [&](std::uint32_t t, std::uint32_t v, std::uint32_t i, std::uint32_t j) {
    if (t == q.t || t == q.u) return false;
    const std::uint32_t other = winner_of[t];
    if (other != kNone && is_rival(winners[other].quad)) rivals.push_back(other);
    if (prism.convex() && (prism.code(v).planes & prism.code(i).planes & prism.code(j).planes) != 0) return false;
    return meets_new(corners(v, i, j));
  };
  bool exists = false, crossing = false;  // the whole fan, so that the reason does not depend on where it begins
  surface_.any_around(q.c, [&](auto t, auto i, auto j) {
    exists = exists || i == q.d || j == q.d;
    crossing = crossing || crosses(t, q.c, i, j);
    return exists;
  });
  if (exists) return Obstacle::EdgeExists;
  if (crossing) return Obstacle::Crossing;
  Bounds box;
  box.add(surface_.at(q.c));
  for (const std::uint32_t v : {q.a, q.b, q.d}) {
    box.add(surface_.at(v));
    if (surface_.any_around(v, [&](auto t, auto i, auto j) { return crosses(t, v, i, j); })) return Obstacle::Crossing;
  }
  const bool found = near_.any_near(box, [&](std::uint32_t v, double reach) {
    if (v == q.a || v == q.b || v == q.c || v == q.d) return false;
    if (prism.convex() && static_cast<double>(prism.code(v).distance) > 0.501 * reach) return false;
    return surface_.any_around(v, [&](auto t, auto i, auto j) { return crosses(t, v, i, j); });
  });
  return found ? Obstacle::Crossing : Obstacle::None;
}

}  // namespace scanmill::optimise
