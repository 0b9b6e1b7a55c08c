// SPDX-License-Identifier: Apache-2.0
#include "report/numbers.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>

namespace scanmill::report {
namespace {

constexpr int kDigits = 4;

std::string fixed(double magnitude, int decimals) {
  char buffer[400];
  std::string text(buffer,
                   std::to_chars(buffer, buffer + sizeof buffer, magnitude, std::chars_format::fixed, decimals).ptr);
  for (std::size_t at = std::min(text.find('.'), text.size()); at > 3;) text.insert(at -= 3, 1, ',');
  return text;
}

std::string magnitude_text(double magnitude) {
  char buffer[64];
  const char* end =
      std::to_chars(buffer, buffer + sizeof buffer, magnitude, std::chars_format::scientific, kDigits - 1).ptr;
  const std::string text(static_cast<const char*>(buffer), end);
  const std::size_t e = text.find('e');
  const int exponent = std::atoi(text.c_str() + e + 1);
  if (exponent < -6 || exponent > 14) return text;
  const int decimals = std::max(0, kDigits - 1 - exponent);
  // 1.2 is not made to look measured: digits that say nothing go, but only where the number is exactly that.
  for (int fewer = 0; fewer < decimals; ++fewer) {
    const char* short_end =
        std::to_chars(buffer, buffer + sizeof buffer, magnitude, std::chars_format::fixed, fewer).ptr;
    double value = 0;
    std::from_chars(buffer, short_end, value);
    if (value == magnitude) return fixed(magnitude, fewer);
  }
  return fixed(magnitude, decimals);
}

}  // namespace

std::string figure(double value) {
  if (std::isnan(value)) return "not known";
  if (value == 0) return "0";
  if (std::isinf(value)) return value < 0 ? "-infinite" : "infinite";
  return (value < 0 ? "-" : "") + magnitude_text(std::abs(value));
}

std::string signed_figure(double value) { return (value > 0 ? "+" : "") + figure(value); }

std::string fixed3(double value) {
  if (!std::isfinite(value) || std::abs(value) > 1e15) return figure(value);
  const std::string text = fixed(std::abs(value), 3);
  return (value < 0 && text != "0.000" ? "-" : "") + text;
}

std::string place(Vec3 p) { return "(" + fixed3(p.x) + ", " + fixed3(p.y) + ", " + fixed3(p.z) + ")"; }

std::string share(std::uint64_t part, std::uint64_t whole) {
  if (whole == 0) return "-";
  double percent = 100 * static_cast<double>(part) / static_cast<double>(whole);
  if (part < whole) percent = std::min(percent, 99.99);
  if (part > 0) percent = std::max(percent, 0.01);
  return part == whole ? "100 %" : part == 0 ? "0 %" : fixed(percent, 2) + " %";
}

}  // namespace scanmill::report
