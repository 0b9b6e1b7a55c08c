// SPDX-License-Identifier: Apache-2.0
// Small flat pieces of every view: the mean and the normal of the points in a cube. A mean of sixty points has an
// eighth of their noise, and a plane through them needs no neighbours of other views.
#pragma once
#include <cstdint>
#include <optional>
#include <vector>

#include "base/context.hpp"
#include "cloud/cloud.hpp"

namespace scanmill::refine {

struct Patch {
  Vec3 centre,
      normal;  // global frame as the source places them; the normal unit, towards the sensor where that is known
  std::uint32_t view = 0;
  double rms = 0;  // of its points about its plane, mm: noise and, on curved surfaces, how far the piece is from flat
  std::uint32_t points = 0;
};

struct Patches {
  double edge_mm = 0;
  std::vector<Patch> list;  // by view, then by cube
  bool sided = true;        // every normal's side is known
};

/// Cubes of `edge_mm`, or of an edge that puts some 60 points of a view in one. Points far from the plane of their cube
/// are left out of it; cubes with few points or without a plane (edges of the part) make no patch.
/// errors  those of the source; BadInput when nothing is left; Cancelled
Result<Patches> patches_of(const PointSource& points, std::optional<double> edge_mm, const Context& context);

}  // namespace scanmill::refine
