// SPDX-License-Identifier: Apache-2.0
// The plane that holds most points. Internal to `clean`.
#pragma once
#include <span>

#include "base/context.hpp"
#include "base/result.hpp"
#include "clean/params.hpp"

namespace scanmill::clean {

struct Plane {
  Vec3 point;   // mm, global frame
  Vec3 normal;  // unit, upwards
  double height(Vec3 p) const { return dot(p - point, normal); }
};

struct FittedPlane {
  Plane plane;
  double share = 0;   // of the sample within distance_mm
  double rms_mm = 0;  // of those
  std::uint64_t sample = 0;
};

/// Random sample consensus (Fischler and Bolles 1981) over a fixed sample, each trial's three points drawn from (seed,
/// trial); the best of 4,096 trials are refined by the moments of the points they hold. Up is the side of `rule.normal`
/// where that is given, else the side with more points off the plane, else fit_plane's sign.
///
/// sample   in an order that is a function of the points
/// errors   BadInput when no plane holds rule.min_share of the sample within rule.distance_mm; Cancelled
/// ties     most points, then the least trial
/// cost     trials x sample, 0.1 s for 8,192 points
Result<FittedPlane> fit_largest_plane(std::span<const Vec3> sample, const PlaneRule& rule, std::uint64_t seed,
                                      const Context& context);

}  // namespace scanmill::clean
