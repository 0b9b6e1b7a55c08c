// SPDX-License-Identifier: Apache-2.0
#include "surfaces/chart_fit.hpp"

#include <algorithm>
#include <cmath>

namespace scanmill::surfaces {
namespace {

constexpr double kSpanBins[] = {16, 11, 8, 5.6, 4, 2.8, 2, 1.4};
constexpr double kWanted = 0.6;      // of the tolerance
constexpr double kRoomBins = 1;      // of the domain around the outline
constexpr double kStiffness = 0.01;  // thin plate: times bin^4 and the points per area
constexpr double kAnchorWeight = 4;

/// The plane's axes: the longer direction of the outline is u.
ChartFrame frame_of(Vec3 axis, std::span<const Vec3> outline) {
  ChartFrame frame;
  frame.n = unit(axis);
  const Vec3 a = perpendicular(frame.n), b = cross(frame.n, a);
  Vec3 centre;
  for (const Vec3& p : outline) centre += p;
  centre = centre * (1 / static_cast<double>(std::max<std::size_t>(outline.size(), 1)));
  double aa = 0, ab = 0, bb = 0;
  for (const Vec3& p : outline) {
    const double x = dot(p - centre, a), y = dot(p - centre, b);
    aa += x * x, ab += x * y, bb += y * y;
  }
  // Eigenvector of the greater eigenvalue of (aa ab; ab bb), from the longer of two equal forms.
  const double half = (aa - bb) / 2, root = std::sqrt(half * half + ab * ab);
  const double x = half >= 0 ? half + root : ab, y = half >= 0 ? ab : root - half;
  frame.u = x * x + y * y > 0 ? unit(a * x + b * y) : a;
  frame.v = cross(frame.n, frame.u);
  frame.origin = centre;
  return frame;
}

struct Extent {
  double length_u = 0, length_v = 0;
};

/// Moves the origin to the low corner of the domain.
Extent place_domain(std::span<const Vec3> outline, const FitTerms& terms, ChartFrame& frame) {
  double low_u = 1e300, low_v = 1e300, high_u = -1e300, high_v = -1e300;
  for (const Vec3& p : outline) {
    const Vec3 q = frame.local(p);
    low_u = std::min(low_u, q.x), high_u = std::max(high_u, q.x);
    low_v = std::min(low_v, q.y), high_v = std::max(high_v, q.y);
  }
  const double room = kRoomBins * terms.bin_mm;
  frame.origin = frame.place({low_u - room, low_v - room, 0});
  return {high_u - low_u + 2 * room, high_v - low_v + 2 * room};
}

CubicSpans spans_over(double length, double span, double quantum) {
  CubicSpans spans;
  spans.spans = static_cast<std::size_t>(std::max(1.0, std::ceil(length / span)));
  spans.step = std::ceil(length / static_cast<double>(spans.spans) / quantum) * quantum;
  return spans;
}

}  // namespace

ChartFit fit_chart(Vec3 axis, const ChartPoints& points, const FitTerms& terms) {
  ChartFit best;
  best.frame = frame_of(axis, points.outline);
  const Extent extent = place_domain(points.outline, terms, best.frame);
  std::vector<FitPoint> places;
  places.reserve(points.samples.size() + points.anchors.size());
  for (const Vec3& p : points.samples) places.push_back({best.frame.local(p), 1});
  const double density = static_cast<double>(points.samples.size() + 1) / (extent.length_u * extent.length_v);
  for (const Vec3& p : points.anchors) places.push_back({best.frame.local(p), kAnchorWeight});
  const double h = terms.bin_mm, stiffness = kStiffness * h * h * h * h * density;
  const std::span<const FitPoint> judged = std::span(places).first(points.samples.size());
  double least = 1e300;
  std::size_t tried_u = 0, tried_v = 0;
  for (const double bins : kSpanBins) {
    const CubicSpans u = spans_over(extent.length_u, bins * h, terms.quantum_mm),
                     v = spans_over(extent.length_v, bins * h, terms.quantum_mm);
    if (u.spans == tried_u && v.spans == tried_v) continue;
    if (tried_u > 0 && u.poles() * v.poles() > kMostPoles) break;
    tried_u = u.spans, tried_v = v.spans;
    HeightField field = fit_heights(u, v, places, stiffness);
    double worst = 0;
    for (const FitPoint& point : judged) {
      // The height is never less than the distance.
      const double height = std::abs(field.at(point.local.x, point.local.y).z - point.local.z);
      if (height > worst) worst = std::max(worst, field.foot(point.local).distance);
    }
    if (worst < 0.95 * least) {
      least = worst;
      best.field = std::move(field);
    }
    if (worst <= kWanted * terms.tolerance_mm) break;
  }
  return best;
}

double rounded(double value, double quantum_mm) { return std::floor(value / quantum_mm + 0.5) * quantum_mm; }
Vec3 rounded(Vec3 p, double quantum_mm) {
  return {rounded(p.x, quantum_mm), rounded(p.y, quantum_mm), rounded(p.z, quantum_mm)};
}

SplineSurface spline_of(const ChartFit& fit, double quantum_mm) {
  SplineSurface surface{fit.field.u, fit.field.v, {}};
  for (std::size_t j = 0; j < surface.v.poles(); ++j)
    for (std::size_t i = 0; i < surface.u.poles(); ++i) {
      const double z = fit.field.heights[j * surface.u.poles() + i];
      surface.poles.push_back(rounded(fit.frame.place({surface.u.greville(i), surface.v.greville(j), z}), quantum_mm));
    }
  return surface;
}

}  // namespace scanmill::surfaces
