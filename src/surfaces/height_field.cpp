// SPDX-License-Identifier: Apache-2.0
#include "surfaces/height_field.hpp"

#include <algorithm>
#include <cmath>

#include "geom/banded.hpp"

namespace scanmill::surfaces {
namespace {

double entry(const std::vector<double>& gram, std::size_t i, std::size_t j) {
  return i <= j ? gram[4 * i + (j - i)] : gram[4 * j + (i - j)];
}

/// Poles in the order that keeps the band narrow: the shorter direction runs fastest.
struct Order {
  std::size_t nu, nv;
  std::size_t row(std::size_t i, std::size_t j) const { return nu <= nv ? j * nu + i : i * nv + j; }
  std::size_t band() const { return 3 * std::min(nu, nv) + 3; }
};

void add_points(const CubicSpans& u, const CubicSpans& v, std::span<const FitPoint> points, const Order& order,
                BandedSystem& system) {
  const CubicTable table_u(u), table_v(v);
  for (const FitPoint& point : points) {
    const CubicTable::Values bu = table_u.at(point.local.x), bv = table_v.at(point.local.y);
    std::array<double, 16> values{};
    std::array<std::size_t, 16> rows{};
    for (std::size_t j = 0; j < 4; ++j)
      for (std::size_t i = 0; i < 4; ++i) {
        values[4 * j + i] = bu.value[i] * bv.value[j];
        rows[4 * j + i] = order.row(bu.first + i, bv.first + j);
      }
    for (std::size_t a = 0; a < 16; ++a) {
      const double scaled = point.weight * values[a];
      system.add_right(rows[a], scaled * point.local.z);
      for (std::size_t b = 0; b < 16; ++b)
        if (rows[b] <= rows[a]) system.add(rows[a], rows[b], scaled * values[b]);
    }
  }
}

void add_plate(const CubicSpans& u, const CubicSpans& v, double stiffness, const Order& order, BandedSystem& system) {
  std::vector<double> gu[3], gv[3];
  for (int d = 0; d < 3; ++d) gu[d] = cubic_gram(u, d), gv[d] = cubic_gram(v, d);
  for (std::size_t j = 0; j < order.nv; ++j)
    for (std::size_t i = 0; i < order.nu; ++i)
      for (std::size_t l = j >= 3 ? j - 3 : 0; l < std::min(order.nv, j + 4); ++l)
        for (std::size_t k = i >= 3 ? i - 3 : 0; k < std::min(order.nu, i + 4); ++k) {
          const std::size_t row = order.row(i, j), column = order.row(k, l);
          if (column > row) continue;
          const double energy = entry(gu[2], i, k) * entry(gv[0], j, l) + 2 * entry(gu[1], i, k) * entry(gv[1], j, l) +
                                entry(gu[0], i, k) * entry(gv[2], j, l);
          system.add(row, column, stiffness * energy);
        }
}

}  // namespace

HeightField::Value HeightField::at(double pu, double pv) const {
  const double cu = std::clamp(pu, 0.0, u.end()), cv = std::clamp(pv, 0.0, v.end());
  const CubicTable::Values bu = table_u_.at(cu), bv = table_v_.at(cv);
  Value value;
  for (std::size_t j = 0; j < 4; ++j) {
    const double* row = &heights[(bv.first + j) * u.poles() + bu.first];
    double z = 0, zu = 0;
    for (std::size_t i = 0; i < 4; ++i) {
      z += bu.value[i] * row[i];
      zu += bu.slope[i] * row[i];
    }
    value.z += bv.value[j] * z;
    value.zu += bv.value[j] * zu;
    value.zv += bv.slope[j] * z;
  }
  value.z += value.zu * (pu - cu) + value.zv * (pv - cv);
  return value;
}

HeightField::Foot HeightField::foot(Vec3 q) const {
  Value value = at(q.x, q.y);
  Foot best{{q.x, q.y, value.z}, std::abs(q.z - value.z)};
  double pu = q.x, pv = q.y;
  for (int step = 0; step < 3; ++step) {
    // Foot on the tangent plane at (pu, pv).
    const double off = q.z - value.z - value.zu * (q.x - pu) - value.zv * (q.y - pv);
    const double share = off / (1 + value.zu * value.zu + value.zv * value.zv);
    pu = q.x + share * value.zu;
    pv = q.y + share * value.zv;
    value = at(pu, pv);
    const Vec3 place{pu, pv, value.z};
    const double distance = norm(q - place);
    const bool settled = distance > 0.98 * best.distance;
    if (distance < best.distance) best = {place, distance};
    if (settled) break;
  }
  return best;
}

HeightField fit_heights(const CubicSpans& u, const CubicSpans& v, std::span<const FitPoint> points, double stiffness) {
  const Order order{u.poles(), v.poles()};
  BandedSystem system(order.nu * order.nv, order.band());
  add_points(u, v, points, order, system);
  add_plate(u, v, stiffness, order, system);
  const std::vector<double> solved = std::move(system).solve();
  std::vector<double> heights(solved.size());
  for (std::size_t j = 0; j < order.nv; ++j)
    for (std::size_t i = 0; i < order.nu; ++i) heights[j * order.nu + i] = solved[order.row(i, j)];
  return HeightField(u, v, std::move(heights));
}

}  // namespace scanmill::surfaces
