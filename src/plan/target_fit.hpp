// SPDX-License-Identifier: Apache-2.0
// A sphere or a plane found among the points of one view.
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "geom/vec3.hpp"

namespace scanmill::plan {

enum class TargetKind { Sphere, Plane };

/// Frame of the points.
struct TargetFit {
  Vec3 centre;                      // of the sphere, or of the plane's points
  Vec3 normal;                      // of the plane, towards the origin
  double radius = 0;                // of the sphere
  double rms_mm = 0;                // of its points
  std::vector<std::uint32_t> rows;  // its points, ascending
};

/// The sphere (of `radius_mm` if given, within a tenth) or plane that holds most points within eight times the noise,
/// from 400 drawn samples, then by least squares on those within four times their own rms. Nothing when fewer than 100
/// points or a tenth of them fit. Drawn from `seed`.
std::optional<TargetFit> find_target(std::span<const Vec3> points, TargetKind kind, std::optional<double> radius_mm,
                                     double noise_mm, std::uint64_t seed);

}  // namespace scanmill::plan
