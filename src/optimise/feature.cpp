// SPDX-License-Identifier: Apache-2.0
#include "optimise/feature.hpp"

#include "optimise/smooth.hpp"

namespace scanmill::optimise {

FeatureRule::FeatureRule(const Surface& surface, const Context& context)
    : surface_(surface), facet_(surface.slot_count()), bend_(kPerSlot * surface.slot_count(), 0) {
  for_each_range(context, facet_.size(), 8192, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) facet_[t] = facet_of(static_cast<std::uint32_t>(t));
  });
  for_each_range(context, facet_.size(), 8192, [&](std::size_t begin, std::size_t end) {
    for (std::size_t h = kPerSlot * begin; h < kPerSlot * end; ++h) bend_[h] = bend_of(static_cast<std::uint32_t>(h));
  });
}

FeatureRule::Facet FeatureRule::facet_of(std::uint32_t slot) const {
  const auto& v = surface_.slot(slot).corner;
  const Vec3 a = surface_.at(v[0]), ab = surface_.at(v[1]) - a, ac = surface_.at(v[2]) - a;
  return {unit(cross(ab, ac)), kAnglePrice * smallest_angle_cos2(norm2(ab), norm2(ac), norm2(ac - ab))};
}

double FeatureRule::bend_of(std::uint32_t half) const {
  const std::uint32_t twin = surface_.twin(half);
  return twin == kNone ? 0 : norm(facet_[slot_of(half)].normal - facet_[slot_of(twin)].normal);
}

double FeatureRule::gain(std::uint32_t half) const {
  constexpr double kLeast = 1e-6;
  const Quad q = surface_.quad(half);
  const double before =
      bend_[half] + bend_[q.bc] + bend_[q.ca] + bend_[q.ad] + bend_[q.db] + facet_[q.t].price + facet_[q.u].price;
  const Vec3 a = surface_.at(q.a), b = surface_.at(q.b), c = surface_.at(q.c), d = surface_.at(q.d);
  const Vec3 cd = d - c, cb = b - c, ca = a - c, db = b - d, da = a - d;
  const double cd2 = norm2(cd);
  double after =
      kAnglePrice * (smallest_angle_cos2(cd2, norm2(db), norm2(cb)) + smallest_angle_cos2(cd2, norm2(ca), norm2(da)));
  if (before - after <= kLeast) return 0;
  const std::uint32_t t_bc = surface_.twin(q.bc), t_ca = surface_.twin(q.ca), t_ad = surface_.twin(q.ad),
                      t_db = surface_.twin(q.db);
  // Whatever n_b is, |n_b - n_bc| + |n_b - n_db| is at least |n_bc - n_db|: often enough to see that nothing is gained.
  double least = after;
  if (t_bc != kNone && t_db != kNone) least += norm(facet_[slot_of(t_bc)].normal - facet_[slot_of(t_db)].normal);
  if (t_ca != kNone && t_ad != kNone) least += norm(facet_[slot_of(t_ca)].normal - facet_[slot_of(t_ad)].normal);
  if (before - least <= kLeast) return 0;
  const Vec3 n_b = unit(cross(cd, cb)), n_a = unit(cross(ca, cd));
  after += norm(n_a - n_b);
  if (t_bc != kNone) after += norm(n_b - facet_[slot_of(t_bc)].normal);
  if (t_db != kNone) after += norm(n_b - facet_[slot_of(t_db)].normal);
  if (t_ca != kNone) after += norm(n_a - facet_[slot_of(t_ca)].normal);
  if (t_ad != kNone) after += norm(n_a - facet_[slot_of(t_ad)].normal);
  return before - after > kLeast ? before - after : 0;
}

void FeatureRule::swapped(const Quad& q) {
  for (const std::uint32_t t : {q.t, q.u}) facet_[t] = facet_of(t);
  for (const std::uint32_t t : {q.t, q.u})
    for (std::uint32_t h = half_of(t, 0); h < half_of(t, 3); ++h) {
      bend_[h] = bend_of(h);
      if (const std::uint32_t twin = surface_.twin(h); twin != kNone) bend_[twin] = bend_[h];
    }
}

}  // namespace scanmill::optimise
