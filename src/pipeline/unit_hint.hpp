// SPDX-License-Identifier: Apache-2.0
// Cloud and mesh in two units: their sizes tell.
#pragma once
#include <mutex>
#include <string>

#include "cloud/cloud.hpp"
#include "geom/vec3.hpp"

namespace scanmill::pipeline {

struct LengthUnit {
  const char *word, *plural;
  double mm;
};
/// The likeliest first.
inline constexpr LengthUnit kLengthUnits[] = {{"mm", "millimetres", 1},
                                              {"m", "metres", 1000},
                                              {"cm", "centimetres", 10},
                                              {"in", "inches", 25.4},
                                              {"um", "micrometres", 0.001}};

/// Passes blocks through and keeps the box of their points.
class BoundedPoints final : public PointSource {
 public:
  explicit BoundedPoints(const PointSource& points) : points_(points) {}
  std::size_t block_count() const override { return points_.block_count(); }
  std::uint64_t expected_points() const override { return points_.expected_points(); }
  Result<void> read_block(std::size_t number, PointBlock& out) const override;
  /// Of all points read so far; not to be called while others read.
  const Bounds& bounds() const { return bounds_; }

 private:
  const PointSource& points_;
  mutable std::mutex mutex_;
  mutable Bounds bounds_;
};

/// What to do when the sizes of cloud and mesh, both in mm, differ by about the ratio of two units; empty when they do
/// not. `units_mm`: the unit in which the cloud was read.
std::string unit_hint(const Bounds& mesh, const Bounds& cloud, double units_mm);

}  // namespace scanmill::pipeline
