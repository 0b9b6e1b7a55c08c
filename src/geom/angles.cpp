// SPDX-License-Identifier: Apache-2.0
#include "geom/angles.hpp"

namespace scanmill {
namespace {

constexpr double kDegrees = 57.29577951308232;  // per radian

/// Arc tangent of t in [0, 1], radians. Taken about 0, tan 22.5 or 1, whichever is nearest, so that the series runs
/// over at most tan(11.25 degrees) = 0.199: its 13th term is below 1e-19.
double arc_tangent(double t) {
  constexpr double kTan11 = 0.198912367379658, kTan22 = 0.41421356237309503, kTan34 = 0.6681786379192989;
  constexpr double kPi8 = 0.39269908169872414, kPi4 = 0.7853981633974483;
  double from = 0;
  if (t > kTan34) {
    from = kPi4;
    t = (t - 1) / (t + 1);
  } else if (t > kTan11) {
    from = kPi8;
    t = (t - kTan22) / (1 + t * kTan22);
  }
  const double s = t * t;
  double sum = 0;
  for (int n = 25; n >= 1; n -= 2) sum = 1.0 / n - s * sum;
  return from + t * sum;
}

}  // namespace

double degrees_of(double sine, double cosine) {
  const double across = std::abs(cosine);
  if (!(sine > 0)) return cosine < 0 ? 180 : 0;
  const double acute =
      sine <= across ? kDegrees * arc_tangent(sine / across) : 90 - kDegrees * arc_tangent(across / sine);
  return cosine < 0 ? 180 - acute : acute;
}

double degrees_between(Vec3 u, Vec3 v) { return degrees_of(norm(cross(u, v)), dot(u, v)); }

double acos_degrees(double cosine) {
  if (cosine >= 1) return 0;
  if (cosine <= -1) return 180;
  return degrees_of(std::sqrt((1 - cosine) * (1 + cosine)), cosine);
}

double degrees_of_chord(double chord) {
  const double half = chord > 0 ? (chord < 2 ? chord / 2 : 1) : 0;
  return 2 * degrees_of(half, std::sqrt(1 - half * half));
}

SineCosine sine_cosine_of(double degrees) {
  double x = std::fmod(degrees, 360.0);  // exact, as are the steps down to [-45, 45]
  const double quarters = std::floor(x / 90 + 0.5);
  x -= quarters * 90;
  const double r = x * 0.017453292519943295, s = r * r;
  double sine = 0, cosine = 0;  // Horner forms of the series; at pi/4 the first term left out is below 1e-18
  for (int n = 16; n >= 2; n -= 2) {
    sine = -s / ((n + 1) * n) * (1 + sine);
    cosine = -s / (n * (n - 1)) * (1 + cosine);
  }
  const double sn = r + r * sine, cs = 1 + cosine;
  switch ((static_cast<int>(quarters) % 4 + 4) % 4) {
    case 1:
      return {cs, 0 - sn};
    case 2:
      return {0 - sn, -cs};
    case 3:
      return {0 - cs, sn};
    default:
      return {sn, cs};
  }
}

}  // namespace scanmill
