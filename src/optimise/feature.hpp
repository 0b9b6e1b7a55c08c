// SPDX-License-Identifier: Apache-2.0
// Second pass: the variation of normals among two triangles and their neighbours falls. Internal to `optimise`.
//
// The paper asks for the least variation of normals and says no more. Two things were measured before this was settled
// (a scanned part with sharp edges, 1.2 mm bins, rms of the mesh to the true surface / 5th percentile of the smallest
// angle of the triangles; before the pass 0.0966 mm / 29.7 degrees):
//   sum of angles between neighbouring normals           0.0660  13.3
//   sum of |n - n'|, the chord of that angle             0.0660  13.3   no arc cosine, so the same bits everywhere
//   sum of 1 - cos                                       0.0661  12.6
//   sum of |n - n'| times the length of the edge         0.0729  18.9
//   sum of |n - n'|, no new angle below 18 degrees       0.0750  21.9
//   sum of |n - n'| + 0.2 cos2(smallest angle)           0.0672  21.4   <- this one
// The bare sum spends half of its swaps on noise in flat places, where they make slivers and gain nothing; a price on
// the smallest angle stops these and leaves those at creases, which gain ten times as much.
#pragma once
#include <vector>

#include "base/context.hpp"
#include "optimise/surface.hpp"

namespace scanmill::optimise {

/// Potential: sum over edges of |n - n'| + kAnglePrice times the sum over triangles of cos2(smallest angle); every swap
/// lowers it.
class FeatureRule {
 public:
  static constexpr double kAnglePrice = 0.2;

  FeatureRule(const Surface& surface, const Context& context);

  /// Fall of the potential.
  double gain(std::uint32_t half) const;
  Vec3 normal(std::uint32_t slot) const { return facet_[slot].normal; }
  void swapped(const Quad& quad);

 private:
  struct Facet {
    Vec3 normal;  // unit
    double price;
  };
  Facet facet_of(std::uint32_t slot) const;
  double bend_of(std::uint32_t half) const;

  const Surface& surface_;
  std::vector<Facet> facet_;  // per slot
  std::vector<double> bend_;  // per half-edge, |n - n'|, the same from both sides; 0 at open edges
};

}  // namespace scanmill::optimise
