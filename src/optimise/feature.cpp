// SPDX-License-Identifier: Apache-2.0
#include "optimise/feature.hpp"

#include <cstdlib>
#include <cmath>

namespace scanmill::optimise {
namespace {
const int MODE = getenv("FM") ? atoi(getenv("FM")) : 0;
double weight(Vec3 p, Vec3 q) { return MODE & 1 ? norm(p - q) : (MODE & 8 ? std::sqrt(norm(p - q)) : 1); }
double chord(Vec3 m, Vec3 n) {
  if (MODE & 2) return norm2(m - n);                // 1 - cos
  if (MODE & 4) return std::acos(std::max(-1.0, std::min(1.0, dot(m, n))));
  return norm(m - n);
}
}  // namespace

FeatureRule::FeatureRule(const Surface& surface, const Context& context)
    : surface_(surface), normal_(surface.slot_count()), bend_(3 * surface.slot_count(), 0) {
  for_each_range(context, normal_.size(), 8192, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) normal_[t] = normal_of(static_cast<std::uint32_t>(t));
  });
  for_each_range(context, normal_.size(), 8192, [&](std::size_t begin, std::size_t end) {
    for (std::size_t h = 3 * begin; h < 3 * end; ++h) bend_[h] = bend_of(static_cast<std::uint32_t>(h));
  });
}

Vec3 FeatureRule::normal_of(std::uint32_t slot) const {
  const auto& v = surface_.slot(slot).corner;
  const Vec3 a = surface_.at(v[0]);
  return unit(cross(surface_.at(v[1]) - a, surface_.at(v[2]) - a));
}

double FeatureRule::bend_of(std::uint32_t half) const {
  const std::uint32_t twin = surface_.twin(half);
  if (twin == kNone) return 0;
  return chord(normal_[half / 3], normal_[twin / 3]) * weight(surface_.at(surface_.from(half)), surface_.at(surface_.to(half)));
}

double FeatureRule::gain(std::uint32_t half) const {
  const Quad q = surface_.quad(half);
  const double before = bend_[half] + bend_[q.bc] + bend_[q.ca] + bend_[q.ad] + bend_[q.db];
  const Vec3 a = surface_.at(q.a), b = surface_.at(q.b), c = surface_.at(q.c), d = surface_.at(q.d);
  const Vec3 n_b = unit(cross(d - c, b - c)), n_a = unit(cross(c - d, a - d));
  double after = chord(n_b, n_a) * weight(c, d);
  auto over = [&](std::uint32_t side, Vec3 n, Vec3 p, Vec3 r) {
    const std::uint32_t twin = surface_.twin(side);
    if (twin != kNone) after += chord(n, normal_[twin / 3]) * weight(p, r);
  };
  over(q.bc, n_b, b, c);
  over(q.ca, n_a, c, a);
  over(q.ad, n_a, a, d);
  over(q.db, n_b, d, b);
  return before - after > 1e-6 ? before - after : 0;
}

void FeatureRule::swapped(const Quad& q) {
  for (const std::uint32_t t : {q.t, q.u}) normal_[t] = normal_of(t);
  for (const std::uint32_t t : {q.t, q.u})
    for (std::uint32_t h = 3 * t; h < 3 * t + 3; ++h) {
      bend_[h] = bend_of(h);
      if (const std::uint32_t twin = surface_.twin(h); twin != kNone) bend_[twin] = bend_[h];
    }
}

}  // namespace scanmill::optimise
