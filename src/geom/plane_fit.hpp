// SPDX-License-Identifier: Apache-2.0
// Least-squares planes from second moments.
#pragma once
#include "geom/vec3.hpp"

namespace scanmill {

/// Symmetric 3x3 matrix: xx xy xz yy yz zz.
struct Covariance {
  double xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;
};

struct PlaneFit {
  Vec3 normal;       // unit; of the two signs the one whose largest component is positive
  double least = 0;  // least eigenvalue, >= 0
  double trace = 0;
};

/// Eigenvector of the least eigenvalue of a positive semidefinite matrix; + - * / sqrt only, so the same bits
/// everywhere. Where no plane stands out (a multiple of the identity, a line) the normal is (0, 0, 1).
PlaneFit fit_plane(const Covariance& c);

}  // namespace scanmill
