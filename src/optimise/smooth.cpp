// SPDX-License-Identifier: Apache-2.0
#include "optimise/smooth.hpp"

#include <algorithm>

namespace scanmill::optimise {

SmoothRule::SmoothRule(const Surface& surface, const Context& context)
    : surface_(surface), cos2_(surface.slot_count()) {
  for_each_range(context, cos2_.size(), 8192, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) cos2_[t] = cos2_of(static_cast<std::uint32_t>(t));
  });
}

double SmoothRule::cos2_of(std::uint32_t slot) const {
  const auto& v = surface_.slot(slot).corner;
  const Vec3 a = surface_.at(v[0]), b = surface_.at(v[1]), c = surface_.at(v[2]);
  return smallest_angle_cos2(norm2(a - b), norm2(b - c), norm2(c - a));
}

double SmoothRule::gain(std::uint32_t half) const {
  constexpr double kLeast = 1e-9;
  const Quad q = surface_.quad(half);
  const Vec3 a = surface_.at(q.a), b = surface_.at(q.b), c = surface_.at(q.c), d = surface_.at(q.d);
  const double before = std::max(cos2_[q.t], cos2_[q.u]), cd = norm2(c - d);
  const double first = smallest_angle_cos2(cd, norm2(d - b), norm2(b - c));
  if (first > before - kLeast) return 0;
  const double second = smallest_angle_cos2(cd, norm2(c - a), norm2(a - d));
  const double gain = before - std::max(first, second);
  return gain > kLeast ? gain : 0;
}

Vec3 SmoothRule::normal(std::uint32_t slot) const {
  const auto& v = surface_.slot(slot).corner;
  const Vec3 a = surface_.at(v[0]);
  return unit(cross(surface_.at(v[1]) - a, surface_.at(v[2]) - a));
}

void SmoothRule::swapped(const Quad& quad) {
  cos2_[quad.t] = cos2_of(quad.t);
  cos2_[quad.u] = cos2_of(quad.u);
}

}  // namespace scanmill::optimise
