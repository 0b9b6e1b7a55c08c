// SPDX-License-Identifier: Apache-2.0
// The guards that need no more than the quadrilateral and its neighbours. Internal to `optimise`.
#pragma once
#include "mesh/limits.hpp"
#include "optimise/params.hpp"
#include "optimise/surface.hpp"

namespace scanmill::optimise {

enum class Refusal : std::uint8_t { None, PatchBorder, NotConvex, Range, Angle, Fold, EdgeExists, Crossing };

/// The projection along the mean normal turns left at every corner, by more than rounding and more than 3 degrees of
/// tilt allow.
inline bool convex_in_mean_plane(const Surface& surface, const Quad& q) {
  constexpr double kLeastDot = 0.05;
  const Vec3 a = surface.at(q.a), b = surface.at(q.b), c = surface.at(q.c), d = surface.at(q.d);
  const Vec3 ab = b - a, dc = c - d, mean = cross(ab, dc);
  const double size2 = kLeastDot * kLeastDot * norm2(mean);
  auto faces_up = [&](Vec3 n) {
    const double up = dot(n, mean);
    return up > 0 && up * up > size2 * norm2(n);
  };
  return faces_up(cross(b - c, dc)) && faces_up(cross(dc, a - d)) && faces_up(cross(ab, c - a)) &&
         faces_up(cross(d - a, ab));
}

/// The first guard that refuses, in the order of Refusal; the last two are CrossingGuard's. normal(slot): unit.
template <class Normal>
Refusal refused_by(const Surface& surface, const Quad& q, const Limits& limits, const Normal& normal) {
  constexpr double kFold = -0.5;
  if (!surface.same_patch(q.t, q.u)) return Refusal::PatchBorder;
  if (!convex_in_mean_plane(surface, q)) return Refusal::NotConvex;
  const Vec3 a = surface.at(q.a), b = surface.at(q.b), c = surface.at(q.c), d = surface.at(q.d);
  if (norm2(c - d) > limits.range_mm * limits.range_mm) return Refusal::Range;
  if (!angles_at_least(c, d, b, limits.cos_min_angle) || !angles_at_least(d, c, a, limits.cos_min_angle))
    return Refusal::Angle;
  const Vec3 n_t = normal(q.t), n_u = normal(q.u);
  const Vec3 n_b = unit(cross(d - c, b - c)), n_a = unit(cross(c - d, a - d));  // of (c, d, b) and (d, c, a)
  double before = dot(n_t, n_u), after = dot(n_a, n_b);
  auto over = [&](std::uint32_t side, Vec3 old_normal, Vec3 new_normal) {
    const std::uint32_t twin = surface.twin(side);
    if (twin == kNone) return;
    const Vec3 n = normal(slot_of(twin));
    before = std::min(before, dot(old_normal, n));
    after = std::min(after, dot(new_normal, n));
  };
  over(q.bc, n_t, n_b);
  over(q.ca, n_t, n_a);
  over(q.ad, n_u, n_a);
  over(q.db, n_u, n_b);
  return after < kFold && after < before ? Refusal::Fold : Refusal::None;
}

}  // namespace scanmill::optimise
