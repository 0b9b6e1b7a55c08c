// SPDX-License-Identifier: Apache-2.0
// One chart: its plane, the domain of its surface, and the coarsest spline that holds the tolerance.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "surfaces/height_field.hpp"

namespace scanmill::surfaces {

struct FitTerms {
  double bin_mm = 1, tolerance_mm = 0.25, quantum_mm = 0.001;
};

struct ChartFit {
  ChartFrame frame;
  HeightField field;

  /// Distance of a place from the surface, and the surface's place there.
  HeightField::Foot foot(Vec3 p) const { return field.foot(frame.local(p)); }
  bool covers(Vec3 p) const {
    const Vec3 q = frame.local(p);
    return q.x >= 0 && q.y >= 0 && q.x <= field.u.end() && q.y <= field.v.end();
  }
};

/// What a chart is fitted to, global frame.
struct ChartPoints {
  std::span<const Vec3> outline;  // the domain has room for these
  std::span<const Vec3> samples;  // all count for the tolerance
  std::span<const Vec3> anchors;  // places of borders, which count more but are not judged
};

/// Spans are halved (by steps of about a square root of two) from 16 bins until every sample lies within 0.6 of the
/// tolerance; where none does, the number of spans with the least greatest distance is taken. At most kMostPoles.
ChartFit fit_chart(Vec3 axis, const ChartPoints& points, const FitTerms& terms);
inline constexpr std::size_t kMostPoles = 900;

/// Poles in space, multiples of the quantum.
SplineSurface spline_of(const ChartFit& fit, double quantum_mm);

/// The nearest multiple.
double rounded(double value, double quantum_mm);
Vec3 rounded(Vec3 p, double quantum_mm);

}  // namespace scanmill::surfaces
