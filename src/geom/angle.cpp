// SPDX-License-Identifier: Apache-2.0
#include "geom/angle.hpp"

#include <array>
#include <cmath>

namespace scanmill {
namespace {

constexpr int kTerms = 18;  // the first one left out is below 6e-15 at 1/2, where the series is used last
constexpr double kDegrees = 57.29577951308232;

/// Coefficients of asin(s) = s (1 + s^2/6 + 3 s^4/40 + ...).
constexpr std::array<double, kTerms> arcsine_series() {
  std::array<double, kTerms> c{};
  double central = 1;  // (2n)! / (4^n n!^2)
  for (int n = 0; n < kTerms; ++n) {
    if (n > 0) central *= (2.0 * n - 1) / (2.0 * n);
    c[static_cast<std::size_t>(n)] = central / (2.0 * n + 1);
  }
  return c;
}
constexpr auto kArcsine = arcsine_series();

/// 0 <= s <= 1/2; radians.
double arcsine(double s) {
  const double t = s * s;
  double sum = 0;
  for (std::size_t n = kTerms; n-- > 0;) sum = sum * t + kArcsine[n];
  return s * sum;
}

}  // namespace

double degrees_of_chord(double chord) {
  const double s = chord >= 2 ? 1 : chord > 0 ? chord / 2 : 0;
  if (s <= 0.5) return 2 * kDegrees * arcsine(s);
  return 180 - 4 * kDegrees * arcsine(std::sqrt((1 - s) / 2));  // asin s = 90 deg - 2 asin sqrt((1 - s) / 2)
}

double acos_degrees(double cosine) {
  const double c = cosine < -1 ? -1 : cosine > 1 ? 1 : cosine;
  if (c < -0.5) return 180 - 2 * kDegrees * arcsine(std::sqrt((1 + c) / 2));
  if (c > 0.5) return 2 * kDegrees * arcsine(std::sqrt((1 - c) / 2));
  return 90 - kDegrees * (c < 0 ? -arcsine(-c) : arcsine(c));
}

}  // namespace scanmill
