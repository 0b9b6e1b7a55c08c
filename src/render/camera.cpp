// SPDX-License-Identifier: Apache-2.0
#include "render/camera.hpp"

#include <algorithm>

namespace scanmill::render {

Axes axes_of(View view) {
  switch (view) {
    case View::PlusX:
      return {{0, 1, 0}, {0, 0, 1}, {1, 0, 0}};
    case View::MinusX:
      return {{0, -1, 0}, {0, 0, 1}, {-1, 0, 0}};
    case View::PlusY:
      return {{-1, 0, 0}, {0, 0, 1}, {0, 1, 0}};
    case View::MinusY:
      return {{1, 0, 0}, {0, 0, 1}, {0, -1, 0}};
    case View::PlusZ:
      return {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    case View::MinusZ:
      return {{-1, 0, 0}, {0, 1, 0}, {0, 0, -1}};
    case View::Iso:
      break;
  }
  const Vec3 toward = unit({1, -1, 1}), right = unit({1, 1, 0});
  return {right, cross(toward, right), toward};
}

Projection fit(const Extent& extent, const Box& box) {
  Projection p;
  p.axes = extent.axes;
  p.middle_x = box.left + box.width / 2;
  p.middle_y = box.top + box.height / 2;
  if (extent.seen.empty()) return p;
  const Vec3 size = extent.seen.size(), middle = extent.seen.low + size * 0.5;
  p.centre = extent.anchor + p.axes.right * middle.x + p.axes.up * middle.y + p.axes.toward * middle.z;
  const double wide = size.x / box.width, tall = size.y / box.height, most = std::max(wide, tall);
  if (most > 0) p.px_per_mm = 1 / most;
  return p;
}

}  // namespace scanmill::render
