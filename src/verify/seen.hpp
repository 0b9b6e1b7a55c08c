// SPDX-License-Identifier: Apache-2.0
// What a pass over points leaves behind; all of it commutes. Internal to `verify`.
#pragma once
#include <atomic>
#include <cstdint>
#include <optional>
#include <vector>

#include "verify/tally.hpp"
#include "verify/vertex_errors.hpp"

namespace scanmill::verify {

/// Of one worker, or of all.
struct Seen {
  std::uint64_t points_read = 0, not_finite = 0, sensor_invalid = 0, points_near = 0;
  Sums interior, open_border, patch_borders;
  Ranks interior_ranks, open_border_ranks, patch_border_ranks;
  std::vector<Sums> patches;
  SignedHistogram histogram;
  Worst worst, worst_interior;

  void add(const Seen& other) {
    points_read += other.points_read;
    not_finite += other.not_finite;
    sensor_invalid += other.sensor_invalid;
    points_near += other.points_near;
    interior.add(other.interior);
    open_border.add(other.open_border);
    patch_borders.add(other.patch_borders);
    interior_ranks.add(other.interior_ranks);
    open_border_ranks.add(other.open_border_ranks);
    patch_border_ranks.add(other.patch_border_ranks);
    for (std::size_t n = 0; n < patches.size(); ++n) patches[n].add(other.patches[n]);
    histogram.below += other.histogram.below;
    histogram.above += other.histogram.above;
    for (std::size_t n = 0; n < histogram.counts.size(); ++n) histogram.counts[n] += other.histogram.counts[n];
    worst.add(other.worst);
    worst_interior.add(other.worst_interior);
  }
};

/// What all workers mark together.
struct Marks {
  std::vector<std::atomic<std::uint8_t>> triangle_near;  // nearest of a point within one bin edge
  std::optional<VertexErrors> vertices;

  Marks(const Mesh& mesh, const Terms& terms) : triangle_near(mesh.triangles.size()) {
    if (terms.vertex_bins) vertices.emplace(mesh.positions.size(), terms.vertex_bins->vertex_of_row.size());
  }
};

}  // namespace scanmill::verify
