// SPDX-License-Identifier: Apache-2.0
// Sphere tracing (Hart 1996) with over-relaxed steps (Keinert et al. 2014): a step longer than the known free ball is
// kept when the ball at its end reaches back to the first. Near the surface the root is bracketed and refined along the
// ray instead, which takes a few evaluations where plain tracing takes dozens at a shallow angle.
#include "simulate/trace.hpp"

#include <algorithm>
#include <cmath>

namespace scanmill::simulate {
namespace {

constexpr double kRelaxation = 1.6;
constexpr double kNear = 0.02;     // mm; far below every radius and wall, so a bracket this short holds one crossing
constexpr double kRoot = 1e-9;     // mm
constexpr double kGrazing = 1e-7;  // mm; a ray this close to the surface that finds no crossing has touched it

/// Root of f between a (f > 0) and b (f <= 0) by the Illinois rule.
template <class F>
double refine(const F& f, double a, double fa, double b, double fb) {
  if (fb == 0) return b;
  int kept = 0;
  for (int i = 0; i < 80; ++i) {
    const double c = (a * fb - b * fa) / (fb - fa), fc = f(c);
    if (std::abs(fc) <= kRoot) return c;
    if (fc > 0) {
      a = c;
      fa = fc;
      if (kept == 1) fb *= 0.5;
      kept = 1;
    } else {
      b = c;
      fb = fc;
      if (kept == 2) fa *= 0.5;
      kept = 2;
    }
  }
  return b;
}

}  // namespace

Interval clip(const Ray& ray, const Bounds& box) {
  Interval range{-1e300, 1e300};
  auto slab = [&](double o, double d, double low, double high) {
    if (d == 0) {
      if (o < low || o > high) range = {1, 0};
      return;
    }
    const double a = (low - o) / d, b = (high - o) / d;
    range.low = std::max(range.low, std::min(a, b));
    range.high = std::min(range.high, std::max(a, b));
  };
  slab(ray.origin.x, ray.direction.x, box.low.x, box.high.x);
  if (range.low <= range.high) slab(ray.origin.y, ray.direction.y, box.low.y, box.high.y);
  if (range.low <= range.high) slab(ray.origin.z, ray.direction.z, box.low.z, box.high.z);
  return range;
}

double first_crossing(const Object& object, const Ray& ray, Interval range, double side) {
  const double missed = range.high + 1;
  auto f = [&](double t) { return side * object.distance(ray.at(t)); };
  double t = range.low, free = f(t), relaxation = kRelaxation;
  while (t <= range.high) {
    if (free <= kNear) {
      if (free <= 0) return t;
      double a = t, fa = free;
      for (double reach = 1.05; reach < 8; reach *= 2) {
        const double b = t + std::max(free, kGrazing) * reach, fb = f(b);
        if (fb <= 0) return refine(f, a, fa, b, fb);
        a = b;
        fa = fb;
      }
      if (free <= kGrazing) return t;
      // No crossing up to `a`, whose own free ball goes on from there.
      t = a + fa;
      free = f(t);
      continue;
    }
    const double step = free * relaxation, next = t + step, ahead = f(next);
    if (relaxation > 1 && free + std::abs(ahead) < step) {
      relaxation = 1;  // the balls do not meet: something may lie between
      continue;
    }
    if (ahead <= 0) return refine(f, t, free, next, ahead);
    t = next;
    free = ahead;
    relaxation = kRelaxation;
  }
  return missed;
}

}  // namespace scanmill::simulate
