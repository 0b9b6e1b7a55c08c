// SPDX-License-Identifier: Apache-2.0
// Second pass: the variation of normals among two triangles and their neighbours falls. Internal to `optimise`.
#pragma once
#include <vector>

#include "base/context.hpp"
#include "optimise/surface.hpp"

namespace scanmill::optimise {

class FeatureRule {
 public:
  FeatureRule(const Surface& surface, const Context& context);

  double gain(std::uint32_t half) const;
  Vec3 normal(std::uint32_t slot) const { return normal_[slot]; }
  void swapped(const Quad& quad);

 private:
  Vec3 normal_of(std::uint32_t slot) const;
  double bend_of(std::uint32_t half) const;

  const Surface& surface_;
  std::vector<Vec3> normal_;   // per slot, unit
  std::vector<double> bend_;   // per half-edge, the same from both sides; 0 at open edges
};

}  // namespace scanmill::optimise
