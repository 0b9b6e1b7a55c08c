// SPDX-License-Identifier: Apache-2.0
// Where completion works: the complex with the geometry around it, and the tests every insertion must pass.
// Internal to `stars`.
#pragma once
#include <span>
#include <utility>
#include <vector>

#include "geom/predicates.hpp"
#include "stars/complex.hpp"
#include "stars/stars.hpp"

namespace scanmill::stars {

/// A function of the angle of (x, y) that grows with it, in [0, 4); no trigonometry.
double pseudo_angle(double x, double y);

class Site {
 public:
  Site(const SurfacePoints& points, const Params& params, std::vector<Vec3> normal);

  Complex complex;
  std::vector<Vec3> normal;  // per vertex; repairs renew some
  /// Old values of normals that a fill turned, newest last; a repair that is undone puts them back.
  std::vector<std::pair<std::uint32_t, Vec3>> turned_normals;
  double fill_fold = -0.8;  // least normal product over an edge of a fill; late repairs allow sharper creases
  const SurfacePoints& points;

  double h() const { return points.edge_mm; }
  Vec3 measured(std::uint32_t v) const { return points.measured[v]; }
  Vec3 projected(std::uint32_t v) const { return points.projected[v]; }
  /// Unit normal on measured coordinates.
  Vec3 normal_of(const Triangle& t) const;

  /// g1 and g2 on measured coordinates.
  bool in_range(std::uint32_t a, std::uint32_t b) const { return norm2(measured(a) - measured(b)) <= range2_; }
  bool within_limits(const Triangle& t) const;
  /// The corner's sector at v between a and b (counter-clockwise) holds no other triangle of v's fan.
  bool sector_free(std::uint32_t v, std::uint32_t a, std::uint32_t b) const;
  bool sectors_free(const Triangle& t) const {
    return sector_free(t[0], t[1], t[2]) && sector_free(t[1], t[2], t[0]) && sector_free(t[2], t[0], t[1]);
  }
  /// No neighbour over an edge is folded by a normal product below `least`.
  bool fold_free(const Triangle& t, double least) const;
  /// Some triangle in reach crosses t (exact); its number, or kNone.
  std::uint32_t crossing_of(const Triangle& t) const;

  /// Pseudo-angle of a about v's normal, on projected positions; [0, 4).
  double angle_at(std::uint32_t v, std::uint32_t a) const;
  /// From `from` counter-clockwise to `to`, [0, 4).
  static double turn(double from, double to) { return to >= from ? to - from : to - from + 4; }

  /// Occupied rows in the window around v's bin; appended.
  void around(std::uint32_t v, int radius, std::vector<std::int32_t>& rows) const {
    reader_.window(points.bins[v], radius, rows);
  }
  /// All other rows within g1 of v, ascending. Kept from the first question on: repairs ask for the same vertices again
  /// and again, and no point moves. Good until the next call.
  std::span<const std::uint32_t> in_range_of(std::uint32_t v) const;
  Corners corners(const Triangle& t) const {
    return {{measured(t[0]), measured(t[1]), measured(t[2])}, {t[0], t[1], t[2]}};
  }

 private:
  void rows_in_reach(const Triangle& t) const;

  double range2_, cos_min_angle_;
  double reach_;      // mm: every point of a triangle is this near to one of its corners
  int front_radius_;  // bins: a window that holds every point within g1
  mutable BinIndex::Reader reader_;
  mutable std::vector<std::int32_t> rows_;
  mutable std::vector<std::uint32_t> range_begin_, range_rows_;  // begin in range_rows_ per vertex: count, then rows
  mutable std::vector<std::uint32_t> seen_;                      // per triangle: number of the query that met it last
  mutable std::uint32_t query_ = 0;
};

}  // namespace scanmill::stars
