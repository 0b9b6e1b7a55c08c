// SPDX-License-Identifier: Apache-2.0
// Most numbers of scan files have at most 15 digits and no exponent. For these digits / 10^k is one correctly rounded
// division of two exact doubles (Clinger 1990), a third of the time std::from_chars takes; all others go to from_chars.
#include "formats/decimal.hpp"

#include <charconv>
#include <cstdint>
#include <limits>
#include <system_error>

namespace scanmill::formats {
namespace {

constexpr double kPowers[] = {1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15};

bool is_digit(char c) { return static_cast<unsigned char>(c - '0') < 10; }

/// from_chars does not say on which side the range was left; the sign of the exponent does.
double beyond_range(const char* p, const char* end) {
  for (; p != end; ++p)
    if ((*p == 'e' || *p == 'E') && p + 1 != end && p[1] == '-') return 0;
  return std::numeric_limits<double>::infinity();
}

const char* parse_slowly(const char* p, const char* end, double& value) {
  if (p != end && *p == '+') {
    ++p;
    if (p != end && *p == '-') return nullptr;
  }
  const auto [stop, error] = std::from_chars(p, end, value);
  if (error == std::errc::invalid_argument) return nullptr;
  if (error == std::errc::result_out_of_range) value = beyond_range(p, stop);
  if (stop != end && *stop == '#') {  // 1.#QNAN, -1.#IND, 1.#INF
    const char* q = stop + 1;
    while (q != end && ((*q >= 'A' && *q <= 'Z') || is_digit(*q))) ++q;
    if (q == stop + 1) return nullptr;
    value = std::numeric_limits<double>::quiet_NaN();
    return q;
  }
  return stop;
}

}  // namespace

const char* parse_decimal(const char* p, const char* end, double& value) {
  const char* q = p;
  bool negative = false;
  if (q != end && (*q == '-' || *q == '+')) negative = *q++ == '-';
  const char* digits = q;
  std::uint64_t mantissa = 0;
  while (q != end && is_digit(*q)) mantissa = mantissa * 10 + static_cast<std::uint64_t>(*q++ - '0');
  auto count = q - digits;
  std::ptrdiff_t decimals = 0;
  if (q != end && *q == '.') {
    const char* fraction = ++q;
    while (q != end && is_digit(*q)) mantissa = mantissa * 10 + static_cast<std::uint64_t>(*q++ - '0');
    decimals = q - fraction;
    count += decimals;
  }
  if (count == 0 || count > 15 || (q != end && (*q == 'e' || *q == 'E' || *q == '#')))
    return parse_slowly(p, end, value);
  const double magnitude = static_cast<double>(static_cast<std::int64_t>(mantissa)) / kPowers[decimals];
  value = negative ? -magnitude : magnitude;
  return q;
}

}  // namespace scanmill::formats
