// SPDX-License-Identifier: Apache-2.0
#include "geom/plane_fit.hpp"

#include <Eigen/Core>
#include <Eigen/Jacobi>
#include <algorithm>

namespace scanmill {

PlaneFit fit_plane(const Covariance& c) {
  Eigen::Matrix3d a;
  a << c.xx, c.xy, c.xz, c.xy, c.yy, c.yz, c.xz, c.yz, c.zz;
  Eigen::Matrix3d v = Eigen::Matrix3d::Identity();
  const double trace = c.xx + c.yy + c.zz;
  const double tiny = trace * trace * 1e-30;
  // Cyclic Jacobi converges quadratically; six sweeps reach the last bit for any symmetric 3x3.
  for (int sweep = 0; sweep < 6; ++sweep) {
    const double off = a(0, 1) * a(0, 1) + a(0, 2) * a(0, 2) + a(1, 2) * a(1, 2);
    if (off <= tiny) break;
    for (int p = 0; p < 2; ++p)
      for (int q = p + 1; q < 3; ++q) {
        Eigen::JacobiRotation<double> rotation;
        if (!rotation.makeJacobi(a, p, q)) continue;
        a.applyOnTheLeft(p, q, rotation.adjoint());
        a.applyOnTheRight(p, q, rotation);
        v.applyOnTheRight(p, q, rotation);
      }
  }
  int least = 0;
  if (a(1, 1) < a(least, least)) least = 1;
  if (a(2, 2) < a(least, least)) least = 2;
  PlaneFit fit;
  fit.trace = trace;
  fit.least = std::max(0.0, a(least, least));
  const double spread = std::max({a(0, 0), a(1, 1), a(2, 2)}) - a(least, least);
  fit.normal = spread > 1e-14 * trace ? unit({v(0, least), v(1, least), v(2, least)}) : Vec3{0, 0, 1};
  const Vec3& n = fit.normal;
  const double x = std::abs(n.x), y = std::abs(n.y), z = std::abs(n.z);
  const double lead = x >= y && x >= z ? n.x : y >= z ? n.y : n.z;
  if (lead < 0) fit.normal = -fit.normal;
  return fit;
}

}  // namespace scanmill
