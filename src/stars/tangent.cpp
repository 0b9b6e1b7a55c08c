// SPDX-License-Identifier: Apache-2.0
#include "stars/tangent.hpp"

#include <cmath>

#include "base/wide.hpp"

namespace scanmill::stars {
namespace {

constexpr double kSheet = 0.8;      // greatest |offset from the tangent plane| / distance of a neighbour
constexpr double kNormalDot = 0.3;  // least |n.n'| of a neighbour (n.n' where both signs are known: thin walls)
constexpr double kNever = 1e300;

/// The entry with the least parameter of a circumcentre along the bisector of `a` (the first of equal ones) among those
/// that turn by more than `least_turn`; -1 when there is none. size in whole steps.
SCANMILL_WIDE int first_turn(const double* __restrict x, const double* __restrict y, const double* __restrict power,
                             int size, double xa, double ya, double f, double sign, double least_turn,
                             double* __restrict best) {
  double all[kMostNear], low[kStep];
  for (int l = 0; l < kStep; ++l) low[l] = kNever;
  size &= -kStep;
  for (int b = 0; b < size; b += kStep) {
#pragma GCC unroll 1
    for (int l = 0; l < kStep; ++l) {
      const double turn = sign * (xa * y[b + l] - ya * x[b + l]);
      const double t = (power[b + l] / 2 - f * (xa * x[b + l] + ya * y[b + l])) / turn;
      const double valid = turn <= least_turn ? kNever : t;
      all[b + l] = valid;
      low[l] = valid < low[l] ? valid : low[l];
    }
  }
  for (int half = kStep / 2; half > 0; half /= 2)
    for (int l = 0; l < half; ++l) low[l] = low[l + half] < low[l] ? low[l + half] : low[l];
  const double least = low[0];
  std::int64_t found = kMostNear;
  for (int k = 0; k < size; ++k) {
    const std::int64_t at = all[k] == least ? k : kMostNear;
    found = at < found ? at : found;
  }
  *best = least;
  return least < kNever ? static_cast<int>(found) : -1;
}

SCANMILL_WIDE void look_wide(const double* __restrict px, const double* __restrict py, const double* __restrict pz,
                             const double* __restrict nx, const double* __restrict ny, const double* __restrict nz,
                             const double* __restrict sure, const double* __restrict weight, int size, const View& view,
                             double* __restrict out_x, double* __restrict out_y, double* __restrict power,
                             double* __restrict belongs) {
  const double ax = view.at.x, ay = view.at.y, az = view.at.z, scale = view.scale;
  const double vx = view.n.x, vy = view.n.y, vz = view.n.z, range2 = view.range2, own = view.weight;
  const double e1x = view.e1.x, e1y = view.e1.y, e1z = view.e1.z, e2x = view.e2.x, e2y = view.e2.y, e2z = view.e2.z;
  size &= -kStep;
  for (int k = 0; k < size; ++k) {
    const double agreement = nx[k] * vx + ny[k] * vy + nz[k] * vz;
    const double same_side = sure[k] > 0 ? agreement : std::abs(agreement);
    const double dx = (px[k] - ax) * scale, dy = (py[k] - ay) * scale, dz = (pz[k] - az) * scale;
    const double d2 = dx * dx + dy * dy + dz * dz, along = dx * vx + dy * vy + dz * vz;
    const double x = dx * e1x + dy * e1y + dz * e1z, y = dx * e2x + dy * e2y + dz * e2z;
    const double stretch = std::sqrt(d2 / (x * x + y * y));
    const bool apart = (same_side < kNormalDot) | (d2 > range2) | (d2 <= 0) | (along * along > kSheet * kSheet * d2);
    out_x[k] = x * stretch;
    out_y[k] = y * stretch;
    power[k] = d2 + own - weight[k];
    belongs[k] = apart ? 0.0 : 1.0;
  }
}

}  // namespace

void Tangent::pad() {
  for (int k = size; k % kStep != 0; ++k) x[k] = y[k] = power[k] = 0;  // no turn
}

int Tangent::next(int a, double sign, double radius2) const {
  const double aa = x[a] * x[a] + y[a] * y[a], f = power[a] / (2 * aa);
  double best;
  const int found = first_turn(x, y, power, size + kStep - 1, x[a], y[a], f, sign, 1e-9 * aa, &best);
  return found >= 0 && (f * f + best * best) * aa > radius2 ? -1 : found;
}

void look(const Near& near, const View& view, Seen& seen) {
  look_wide(near.x, near.y, near.z, near.nx, near.ny, near.nz, near.sure, near.weight, near.size + kStep - 1, view,
            seen.x, seen.y, seen.power, seen.belongs);
}

}  // namespace scanmill::stars
