// SPDX-License-Identifier: Apache-2.0
// A cloud of any size for benches of scale: a closed, bumpy ball measured from many sides, point by point from its row.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "geom/vec3.hpp"

namespace scanmill::simulate {

/// Points of the surface r(d) = R (1 + 0.01 (T6(x) + T6(y) + T6(z))), d = (x, y, z) a direction and T6(cos t) = cos 6t,
/// seen by views spread evenly around it. Each view looks at a cap along scan lines in raster order, 64 degrees to each
/// side where there are few views, less where there are many: every place is seen by about seven. The noise is 20 um
/// along the line of sight. The number of points sets the size of the ball, not its density: there are
/// 40 points on a square millimetre whatever their number, as of a larger part under the same scanner.
///
/// A point follows from (points, seed, row) by + - * / and sqrt alone: the same bytes on every machine, in whatever
/// pieces and order they are asked for.
class BumpyBall {
 public:
  using Point = std::array<float, 3>;  // mm
  static constexpr double kPointsPerMm2 = 40, kNoiseMm = 0.02;

  /// points >= 1
  BumpyBall(std::uint64_t points, std::uint64_t seed);

  std::uint64_t points() const { return points_; }
  std::size_t views() const { return axes_.size(); }
  /// Row of the first point of a view; points() for views().
  std::uint64_t first_of_view(std::size_t view) const;
  double radius_mm() const { return radius_; }
  /// Half the edge of a box about the origin that holds every point, noise included.
  double reach_mm() const;
  /// Rows first, first + 1, ... below points(). Cost about 40 ns a point; safe to call from several threads.
  void fill(std::uint64_t first, std::span<Point> out) const;

 private:
  struct Axes {
    Vec3 u, w, towards;  // along a scan line, from line to line, towards the sensor
  };
  void fill_line(const Axes& axes, double w, std::uint64_t columns, std::uint64_t column, std::uint64_t row,
                 std::span<Point> out) const;
  /// Points on the lines before each line of a view of `points`, and all of them.
  static std::vector<std::uint64_t> line_starts(std::uint64_t points);

  std::uint64_t points_, seed_;
  double radius_, cap_ = 1;  // cap: sine of the angle a view looks at to each side
  std::vector<Axes> axes_;
  std::vector<std::uint64_t> starts_[2];  // of views of points / views and of one more
};

}  // namespace scanmill::simulate
