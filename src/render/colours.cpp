// SPDX-License-Identifier: Apache-2.0
#include "render/colours.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace scanmill::render {
namespace {

constexpr Rgb kPatches[] = {{94, 164, 214}, {236, 152, 56},  {96, 184, 120}, {196, 118, 178}, {240, 216, 84},
                            {208, 94, 72},  {126, 126, 196}, {150, 196, 64}, {164, 124, 92},  {112, 200, 200}};

struct Stop {
  double at;
  double r, g, b;
};
// Lightness falls evenly from the middle to both ends, so the scale also reads in grey, as magnitude.
constexpr Stop kStops[] = {{-1, 24, 62, 150},     {-0.6, 74, 138, 208}, {-0.25, 176, 208, 236}, {0, 248, 248, 246},
                           {0.25, 246, 200, 174}, {0.6, 222, 106, 82},  {1, 158, 14, 38}};

std::uint8_t channel(double value) { return static_cast<std::uint8_t>(std::clamp(value + 0.5, 0.0, 255.0)); }

/// 10^exponent times 1, 2 or 5 by the step's number; exact for the powers that doubles hold.
double step_125(int number) {
  const int exponent = number >= 0 ? number / 3 : -((2 - number) / 3);
  const double digit = number - 3 * exponent == 0 ? 1 : number - 3 * exponent == 1 ? 2 : 5;
  double power = 1;
  for (int i = 0; i < std::abs(exponent); ++i) power *= 10;
  return exponent >= 0 ? digit * power : digit / power;
}

}  // namespace

Rgb patch_colour(std::uint32_t patch) {
  constexpr auto kCount = static_cast<std::uint32_t>(std::size(kPatches));
  const Rgb base = kPatches[patch % kCount];
  const int tint = static_cast<int>(patch / kCount % 3);
  if (tint == 0) return base;
  const double share = tint == 1 ? 0.4 : 0.2, to = tint == 1 ? 255 : 0;
  const auto mixed = [&](std::uint8_t c) { return channel(c + (to - c) * share); };
  return {mixed(base.r), mixed(base.g), mixed(base.b)};
}

ErrorScale::ErrorScale() {
  for (int i = -kSteps; i <= kSteps; ++i) {
    const double t = static_cast<double>(i) / kSteps;
    std::size_t k = 1;
    while (k + 1 < std::size(kStops) && t > kStops[k].at) ++k;
    const Stop &a = kStops[k - 1], &b = kStops[k];
    const double u = (t - a.at) / (b.at - a.at);
    table_[static_cast<std::size_t>(i + kSteps)] = {channel(a.r + (b.r - a.r) * u), channel(a.g + (b.g - a.g) * u),
                                                    channel(a.b + (b.b - a.b) * u)};
  }
}

Rgb ErrorScale::at(double t) const {
  if (std::isnan(t)) return kUnknown;
  if (t < -1) return kBelow;
  if (t > 1) return kAbove;
  return table_[static_cast<std::size_t>((t + 1) * kSteps + 0.5)];
}

double rounded_up_125(double value) {
  if (!(value > 0) || !std::isfinite(value)) return 0.001;
  int number = -27;  // 1e-9 mm: nothing finer is ever drawn
  while (number < 900 && step_125(number) < value) ++number;
  return step_125(number);
}

double rounded_down_125(double value) {
  int number = -27;
  while (number < 900 && step_125(number + 1) <= value) ++number;
  return step_125(number);
}

}  // namespace scanmill::render
