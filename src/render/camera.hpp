// SPDX-License-Identifier: Apache-2.0
// Where a part lands in the picture: parallel projection along an axis or the diagonal of the cube.
#pragma once
#include <cstdint>

#include "geom/vec3.hpp"

namespace scanmill::render {

/// The side the viewer stands on. Iso: on the side of +x, -y and +z, all axes equally foreshortened, z up.
enum class View : std::int32_t { Iso, PlusX, MinusX, PlusY, MinusY, PlusZ, MinusZ };

/// Unit vectors, right-handed: right x up = toward (the viewer).
struct Axes {
  Vec3 right, up, toward;
};
/// From the sides z points up; from above and below y does.
Axes axes_of(View view);

/// A box of pixels, y down.
struct Box {
  double left = 0, top = 0, width = 0, height = 0;
};

/// Pixels, y down; depth in pixels too, growing towards the viewer.
struct Spot {
  double x = 0, y = 0, depth = 0;
};

struct Projection {
  Axes axes;
  Vec3 centre;  // lands in the middle of the box
  double px_per_mm = 1, middle_x = 0, middle_y = 0;

  Spot operator()(Vec3 p) const {
    const Vec3 d = (p - centre) * px_per_mm;
    return {middle_x + dot(d, axes.right), middle_y - dot(d, axes.up), dot(d, axes.toward)};
  }
};

/// What is to be seen, in the axes of the view and relative to a point near its middle.
struct Extent {
  Axes axes;
  Vec3 anchor;
  Bounds seen;  // x right, y up, z toward
  void add(Vec3 p) {
    seen.add(Vec3{dot(p - anchor, axes.right), dot(p - anchor, axes.up), dot(p - anchor, axes.toward)});
  }
};

/// As large as the box allows; something without width and height is drawn at one pixel per mm.
Projection fit(const Extent& extent, const Box& box);

}  // namespace scanmill::render
