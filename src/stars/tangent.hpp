// SPDX-License-Identifier: Apache-2.0
// The neighbours of one point on its tangent plane, in arrays that loops walk through without branches. Internal to
// `stars`.
#pragma once
#include <cstddef>
#include <cstdint>

#include "geom/vec3.hpp"

namespace scanmill::stars {

inline constexpr int kMostNear = 128;  // a window of 125 bins, filled up to whole steps of kStep
inline constexpr int kStep = 8;

/// Candidates as they stand in the window: projected position and normal.
struct Near {
  double x[kMostNear], y[kMostNear], z[kMostNear];
  double nx[kMostNear], ny[kMostNear], nz[kMostNear];
  double sure[kMostNear];    // 1: the side of both normals is known, so opposite ones are far apart; else 0
  double weight[kMostNear];  // tells ties apart
  std::uint32_t row[kMostNear];
  int size = 0;
};

/// Where the candidates are looked at from.
struct View {
  Vec3 at, n, e1, e2;
  double scale, range2, weight;  // scale: mm to bin edges; range2: squared bin edges
};

/// Neighbours on the tangent plane; x, y in bin edges, power = squared distance less the difference of weights.
struct Tangent {
  double x[kMostNear], y[kMostNear], power[kMostNear];
  std::uint32_t row[kMostNear];
  int size = 0;

  /// Fills the arrays up to whole steps with entries that are nobody's next.
  void pad();
  /// Next neighbour of the star after `a`, turning left (sign 1) or right (-1); -1 at a gap.
  int next(int a, double sign, double radius2) const;
};

/// x, y, power of every candidate, and whether it belongs to the same sheet (1 or 0); `near` may hold anything up to
/// the next whole step.
struct Seen {
  double x[kMostNear], y[kMostNear], power[kMostNear], belongs[kMostNear];
};
void look(const Near& near, const View& view, Seen& seen);

}  // namespace scanmill::stars
