// SPDX-License-Identifier: Apache-2.0
// Pictures of a scan: the machine's bodies, the way of the head, where it looks, and the part; and the joints over
// time.
#pragma once
#include <span>
#include <string>
#include <vector>

#include "base/context.hpp"
#include "base/result.hpp"
#include "geom/pose.hpp"
#include "render/image.hpp"

namespace scanmill::render {

/// A box in a frame of its own.
struct RigBody {
  Pose frame;
  Vec3 low, high;
  Rgb colour;
};

struct RigLine {
  std::vector<Vec3> points;
  Rgb colour;
  double width_px = 1.5;
};

struct RigLabel {
  Vec3 at;
  std::string text;
};

/// Global frame, mm; nothing of `points` is copied.
struct RigScene {
  std::vector<RigBody> bodies;
  std::vector<RigLine> lines;
  std::vector<RigLabel> labels;
  std::span<const Vec3> points;  // of the part
  Bounds focus;                  // what the panels show; empty: everything
  std::string title;
  std::vector<std::string> caption;  // below the first panel
};

/// Four panels to one scale bar each: isometric, from the front (-y), from above (+z), from the right (+x).
/// errors  BadParameter below 640x480 or above 16384x16384; Cancelled
Result<Image> draw_rig(const RigScene& scene, int width, int height, const Context& context);

/// One joint over time.
struct TimelineLane {
  std::string name;        // with its unit
  std::vector<double> at;  // abscissa, ascending
  std::vector<double> value;
};
struct TimelineMark {
  double at = 0;
  std::string text;
};
/// Lanes one below the other with a common abscissa; marks are vertical lines, named as far as there is room.
/// errors  BadParameter below 640x240 or above 16384x16384
Result<Image> draw_timeline(std::span<const TimelineLane> lanes, std::span<const TimelineMark> marks,
                            const std::string& title, const std::string& abscissa, int width, int height);

}  // namespace scanmill::render
