// SPDX-License-Identifier: Apache-2.0
// Which patch of another view is the same place of the surface.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "base/context.hpp"
#include "geom/pose.hpp"
#include "refine/patches.hpp"

namespace scanmill::refine {

/// Patch `a` and the patch of another view nearest to it.
struct Match {
  std::uint32_t a = 0, b = 0;  // rows of the patches
  Vec3 normal;                 // mean of both normals, unit
  double gap = 0;              // (a - b) . normal, mm: zero where both lie on one sphere (Rusinkiewicz 2019)
};

/// For every patch, in order, its nearest one in each other view (ascending views), where that is nearer than one edge
/// and a half and their normals are within 25 degrees. Ties: the lower row.
/// errors  Cancelled gives an empty list
std::vector<Match> matches_of(const Patches& patches, const Context& context);

}  // namespace scanmill::refine
