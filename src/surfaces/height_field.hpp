// SPDX-License-Identifier: Apache-2.0
// A chart's surface as heights over its plane: parameters are affine in space, so a curve and its image on the plane
// have the same degree and knots, and fitting is one linear system.
#pragma once
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "geom/cubic.hpp"
#include "geom/vec3.hpp"
#include "mesh/fitted.hpp"

namespace scanmill::surfaces {

/// Unit vectors, u x v = n.
struct ChartFrame {
  Vec3 origin, u, v, n;
  Vec3 local(Vec3 p) const { return {dot(p - origin, u), dot(p - origin, v), dot(p - origin, n)}; }
  Vec3 place(Vec3 q) const { return origin + u * q.x + v * q.y + n * q.z; }
};

/// A place with how much it counts.
struct FitPoint {
  Vec3 local;  // in the chart's frame
  double weight = 1;
};

class HeightField {
 public:
  HeightField() = default;
  /// Heights of the poles, u fastest.
  HeightField(const CubicSpans& along_u, const CubicSpans& along_v, std::vector<double> pole_heights)
      : u(along_u), v(along_v), heights(std::move(pole_heights)), table_u_(u), table_v_(v) {}
  CubicSpans u, v;
  std::vector<double> heights;

  /// Height and its slopes; beyond the domain the border's value goes on along its slope.
  struct Value {
    double z = 0, zu = 0, zv = 0;
  };
  Value at(double pu, double pv) const;
  /// A place of the surface that is hardly farther from `q` than the nearest one, and its distance.
  struct Foot {
    Vec3 local;
    double distance = 0;
  };
  Foot foot(Vec3 q) const;

 private:
  CubicTable table_u_, table_v_;
};

/// Least squares with a thin-plate term: the sum of weight (z - height)^2 plus `stiffness` times the integral of the
/// squared second derivatives.
/// cost  O(points) + O(poles^2.. of the narrower side): 10 ms for 400 poles
HeightField fit_heights(const CubicSpans& u, const CubicSpans& v, std::span<const FitPoint> points, double stiffness);

}  // namespace scanmill::surfaces
