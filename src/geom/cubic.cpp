// SPDX-License-Identifier: Apache-2.0
#include "geom/cubic.hpp"

#include <algorithm>

namespace scanmill {
namespace {

/// Basis functions of one degree on the span [knot(3 + s), knot(4 + s)], by the recurrence.
template <std::size_t Degree>
std::array<double, Degree + 1> functions(const CubicSpans& spans, std::size_t span, double t) {
  std::array<double, Degree + 1> n{}, left{}, right{};
  const std::size_t k = span + 3;
  n[0] = 1;
  for (std::size_t j = 1; j <= Degree; ++j) {
    left[j] = t - spans.knot(k + 1 - j);
    right[j] = spans.knot(k + j) - t;
    double saved = 0;
    for (std::size_t r = 0; r < j; ++r) {
      const double part = n[r] / (right[r + 1] + left[j - r]);
      n[r] = saved + right[r + 1] * part;
      saved = left[j - r] * part;
    }
    n[j] = saved;
  }
  return n;
}

}  // namespace

CubicBasis CubicSpans::basis(double t) const {
  const double place = t / step;
  const std::size_t span = !(place > 0) ? 0 : std::min(spans - 1, static_cast<std::size_t>(place));
  CubicBasis b;
  b.first = span;
  b.value = functions<3>(*this, span, t);
  const auto square = functions<2>(*this, span, t);
  const auto line = functions<1>(*this, span, t);
  // Derivatives by differences of the functions one degree below, each over the length of its support.
  std::array<double, 3> square_slope{};
  for (std::size_t i = 0; i < 3; ++i) {  // support knots span + 1 + i ... span + 4 + i
    const double before = i > 0 ? line[i - 1] / (knot(span + 3 + i) - knot(span + 1 + i)) : 0;
    const double after = i < 2 ? line[i] / (knot(span + 4 + i) - knot(span + 2 + i)) : 0;
    square_slope[i] = 2 * (before - after);
  }
  for (std::size_t i = 0; i < 4; ++i) {  // support knots span + i ... span + 4 + i
    const double low = i > 0 ? 1 / (knot(span + 3 + i) - knot(span + i)) : 0;
    const double high = i < 3 ? 1 / (knot(span + 4 + i) - knot(span + 1 + i)) : 0;
    b.slope[i] = 3 * ((i > 0 ? square[i - 1] * low : 0) - (i < 3 ? square[i] * high : 0));
    b.bend[i] = 3 * ((i > 0 ? square_slope[i - 1] * low : 0) - (i < 3 ? square_slope[i] * high : 0));
  }
  return b;
}

CubicTable::CubicTable(const CubicSpans& spans) : step_(spans.step), spans_(spans.spans) {
  for (std::size_t s = 0; s < spans_.size(); ++s) {
    const CubicBasis begin = spans.basis(static_cast<double>(s) * step_),
                     middle = spans.basis((static_cast<double>(s) + 0.5) * step_);
    // At a knot, rounding may give the span before; the middle decides, and the functions are smooth.
    const std::size_t shift = middle.first - begin.first;
    for (std::size_t i = 0; i < 4; ++i) {
      auto& power = spans_[s][i];
      const std::size_t k = i + shift;
      power[0] = k < 4 ? begin.value[k] : 0;
      power[1] = k < 4 ? begin.slope[k] * step_ : 0;
      power[2] = k < 4 ? begin.bend[k] * step_ * step_ / 2 : 0;
      // The second derivative is linear.
      power[3] = (middle.bend[i] * step_ * step_ / 2 - power[2]) * 2 / 3;
    }
  }
}

CubicTable::Values CubicTable::at(double t) const {
  const double place = t / step_;
  const std::size_t span = !(place > 0) ? 0 : std::min(spans_.size() - 1, static_cast<std::size_t>(place));
  const double x = place - static_cast<double>(span);
  Values values;
  values.first = span;
  for (std::size_t i = 0; i < 4; ++i) {
    const auto& p = spans_[span][i];
    values.value[i] = ((p[3] * x + p[2]) * x + p[1]) * x + p[0];
    values.slope[i] = ((3 * p[3] * x + 2 * p[2]) * x + p[1]) / step_;
  }
  return values;
}

std::vector<double> cubic_gram(const CubicSpans& spans, int order) {
  // Four Gauss points are exact up to degree seven; here six.
  constexpr double kPlace[] = {0.06943184420297371, 0.33000947820757187, 0.66999052179242813, 0.93056815579702629};
  constexpr double kWeight[] = {0.17392742256872693, 0.32607257743127307, 0.32607257743127307, 0.17392742256872693};
  std::vector<double> gram(4 * spans.poles(), 0.0);
  for (std::size_t s = 0; s < spans.spans; ++s)
    for (std::size_t g = 0; g < 4; ++g) {
      const CubicBasis b = spans.basis((static_cast<double>(s) + kPlace[g]) * spans.step);
      const auto& f = order == 0 ? b.value : order == 1 ? b.slope : b.bend;
      for (std::size_t i = 0; i < 4; ++i)
        for (std::size_t j = i; j < 4; ++j) gram[4 * (b.first + i) + (j - i)] += kWeight[g] * spans.step * f[i] * f[j];
    }
  return gram;
}

}  // namespace scanmill
