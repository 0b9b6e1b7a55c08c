// SPDX-License-Identifier: Apache-2.0
// The least root of the characteristic polynomial by Newton's method from the left, where the cubic of a positive
// semidefinite matrix lets it climb monotonically; then the eigenvector from the rows' cross products. A fixed number
// of + - * / sqrt, a third of the time of a general solver, and no trigonometry.
#include "geom/plane_fit.hpp"

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace scanmill {
namespace {

constexpr int kSteps = 60;  // a double root halves the distance per step; simple ones need six

/// Least root of x^3 - trace x^2 + minors x - det, for three real roots >= 0.
double least_root(double trace, double minors, double det) {
  double x = 0;
  for (int step = 0; step < kSteps; ++step) {
    const double value = ((x - trace) * x + minors) * x - det, slope = (3 * x - 2 * trace) * x + minors;
    if (!(slope > 0) || !(value < 0)) break;
    const double next = x - value / slope;
    if (!(next > x)) break;
    const bool settled = next - x <= 1e-15 * next;
    x = next;
    if (settled) break;
  }
  return x;
}

}  // namespace

PlaneFit fit_plane(const Covariance& c) {
  PlaneFit fit;
  fit.trace = c.xx + c.yy + c.zz;
  if (!(fit.trace > 0)) {
    fit.normal = {0, 0, 1};
    return fit;
  }
  const double scale = 1 / fit.trace;  // eigenvalues in [0, 1]
  const double xx = c.xx * scale, xy = c.xy * scale, xz = c.xz * scale, yy = c.yy * scale, yz = c.yz * scale,
               zz = c.zz * scale;
  const double minors = xx * yy - xy * xy + xx * zz - xz * xz + yy * zz - yz * yz;
  const double det = xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz);
  const double least = least_root(1, minors, det);
  const Eigen::Vector3d a(xx - least, xy, xz), b(xy, yy - least, yz), d(xz, yz, zz - least);
  const Eigen::Vector3d products[3] = {a.cross(b), a.cross(d), b.cross(d)};
  const Eigen::Vector3d* longest = &products[0];
  for (const Eigen::Vector3d& product : products)
    if (product.squaredNorm() > longest->squaredNorm()) longest = &product;
  fit.least = least * fit.trace;
  // A multiple of the identity, or points on a line: no plane stands out.
  fit.normal = longest->squaredNorm() > 1e-28 ? unit({longest->x(), longest->y(), longest->z()}) : Vec3{0, 0, 1};
  const Vec3& n = fit.normal;
  const double x = std::abs(n.x), y = std::abs(n.y), z = std::abs(n.z);
  const double lead = x >= y && x >= z ? n.x : y >= z ? n.y : n.z;
  if (lead < 0) fit.normal = -fit.normal;
  return fit;
}

}  // namespace scanmill
