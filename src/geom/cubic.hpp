// SPDX-License-Identifier: Apache-2.0
// Cubic B-splines over equal spans with clamped ends: knots 0 0 0 0 s 2s ... ns ns ns ns, n + 3 poles.
#pragma once
#include <array>
#include <cstddef>
#include <vector>

namespace scanmill {

/// The four basis functions that are not zero at a place, with their first and second derivatives.
struct CubicBasis {
  std::size_t first = 0;  // pole of value[0]
  std::array<double, 4> value{}, slope{}, bend{};
};

struct CubicSpans {
  std::size_t spans = 1;
  double step = 1;

  std::size_t poles() const { return spans + 3; }
  double end() const { return static_cast<double>(spans) * step; }
  double knot(std::size_t k) const {  // k in [0, poles + 4)
    const std::size_t inner = k < 3 ? 0 : k - 3 > spans ? spans : k - 3;
    return static_cast<double>(inner) * step;
  }
  /// Where poles must stand for a straight line: the mean of three knots.
  double greville(std::size_t pole) const { return (knot(pole + 1) + knot(pole + 2) + knot(pole + 3)) / 3; }
  /// At t in [0, end]; beyond, the end's polynomial goes on. source  Piegl and Tiller, The NURBS Book (1997), A2.2,
  /// A2.3
  CubicBasis basis(double t) const;
};

/// The same functions as polynomials of each span, for many evaluations.
class CubicTable {
 public:
  CubicTable() = default;
  explicit CubicTable(const CubicSpans& spans);
  struct Values {
    std::size_t first = 0;
    std::array<double, 4> value, slope;
  };
  /// At t in [0, end].
  Values at(double t) const;

 private:
  double step_ = 1;
  std::vector<std::array<std::array<double, 4>, 4>> spans_;  // per span and function: powers of the place in the span
};

/// Integrals over [0, end] of the products of basis functions (order 0), slopes (1) or second derivatives (2):
/// gram[4 i + d] is that of poles i and i + d.
std::vector<double> cubic_gram(const CubicSpans& spans, int order);

}  // namespace scanmill
