// SPDX-License-Identifier: Apache-2.0
// A finished mesh as lists of a part (part_lists.hpp).
#pragma once
#include "pipeline/part_lists.hpp"
#include "pipeline/surface.hpp"

namespace scanmill::pipeline {

/// What distances are measured against, for either direction.
template <class Store, class Surface>
void store_judged(Store& store, Surface& surface) {
  store(surface.mesh.positions, surface.mesh.triangles, surface.mesh.patch, surface.mesh.offset, surface.vertex_row,
        surface.stray_rows);
}

template <class Store, class Surface>
void store_rest(Store& store, Surface& surface) {
  auto& patches = surface.patches;
  store(patches.patch, patches.rank, patches.patches, patches.refused_normal);
  store(surface.borders, surface.strays, surface.loops, surface.stars, surface.refused, surface.refused_overlap,
        surface.components, surface.sides_by_volume, surface.kept_used, surface.kept_in_strays);
}

}  // namespace scanmill::pipeline
