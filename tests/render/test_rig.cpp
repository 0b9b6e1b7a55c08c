// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "render/rig_picture.hpp"

namespace scanmill::render {
namespace {

constexpr Rgb kRed{200, 30, 30}, kLine{10, 120, 10};

struct Workers {
  explicit Workers(int threads) : loop(threads) {}
  ChunkLoop loop;
  CancelFlag cancel;
  Context context() const { return {loop, cancel}; }
};

/// Pixels of a panel that are more red than anything else (lit faces), or exactly of a colour.
struct Found {
  std::size_t red = 0, line = 0;
  double x = 0, y = 0;  // mean of the red ones
};
Found look(const Image& image, int left, int top, int width, int height) {
  Found found;
  for (int y = top; y < top + height; ++y)
    for (int x = left; x < left + width; ++x) {
      const Rgb c = image.pixel(x, y);
      if (c.r > 60 && c.r > 2 * c.g && c.r > 2 * c.b) {
        ++found.red;
        found.x += x - left;
        found.y += y - top;
      }
      found.line += c == kLine;
    }
  found.x /= static_cast<double>(found.red);
  found.y /= static_cast<double>(found.red);
  return found;
}

RigScene scene() {
  RigScene s;
  // a red block at +x, +y, high up, seen in a cube of 100 mm
  s.bodies.push_back({pose_shifted({30, 20, 35}), {-8, -8, -8}, {8, 8, 8}, kRed});
  s.lines.push_back({{{-50, -50, -50}, {-50, -50, 50}}, kLine, 3});
  s.focus.add(Vec3{-50, -50, -50});
  s.focus.add(Vec3{50, 50, 50});
  return s;
}

TEST(DrawRig, ShowsABodyAtItsPlaceInEveryPanel) {
  const Workers workers(1);
  const auto image = draw_rig(scene(), 800, 800, workers.context());
  ASSERT_TRUE(image.ok());
  const Found front = look(*image, 400, 0, 400, 400), top = look(*image, 0, 400, 400, 400),
              side = look(*image, 400, 400, 400, 400);
  EXPECT_GT(look(*image, 0, 0, 400, 400).red, 500u);
  for (const Found& panel : {front, top, side}) EXPECT_GT(panel.red, 500u);
  EXPECT_GT(front.x, 240);  // +x to the right, +z up
  EXPECT_LT(front.y, 120);
  EXPECT_GT(top.x, 240);  // +x to the right, +y up
  EXPECT_LT(top.y, 160);
  EXPECT_GT(side.x, 220);  // from +x: +y to the right, +z up
  EXPECT_LT(side.y, 120);
  EXPECT_GT(front.line, 300u);
}

TEST(DrawRig, IsTheSameForAnyThreadsAndBearsNothing) {
  const Workers one(1), seven(7);
  const auto a = draw_rig(scene(), 640, 480, one.context()), b = draw_rig(scene(), 640, 480, seven.context());
  ASSERT_TRUE(a.ok() && b.ok());
  EXPECT_EQ(*a, *b);
  EXPECT_TRUE(draw_rig({}, 640, 480, one.context()).ok());
  EXPECT_FALSE(draw_rig({}, 100, 480, one.context()).ok());
  RigScene wild = scene();
  wild.lines.push_back({{{1e300, 0, 0}, {0, 0, 1e7}, {0, 0, -1e7}}, kLine, 2});
  wild.bodies.push_back({{}, {-1e200, 0, 0}, {1, 1, 1}, kRed});
  EXPECT_TRUE(draw_rig(wild, 640, 480, one.context()).ok());
}

TEST(DrawTimeline, DrawsALanePerJoint) {
  const std::vector<TimelineLane> lanes{{"x [mm]", {0, 1, 2}, {0, 10, 10}}, {"b [deg]", {0, 2}, {-90, -90}}};
  const std::vector<TimelineMark> marks{{1, "first"}, {2, "second"}};
  const auto image = draw_timeline(lanes, marks, "moves", "seconds", 800, 400);
  ASSERT_TRUE(image.ok());
  std::size_t inked = 0;
  for (int y = 0; y < 400; ++y)
    for (int x = 0; x < 800; ++x) inked += !(image->pixel(x, y) == Rgb{255, 255, 255});
  EXPECT_GT(inked, 3000u);
  EXPECT_TRUE(draw_timeline({}, {}, "", "", 640, 240).ok());
  EXPECT_FALSE(draw_timeline({}, {}, "", "", 64, 240).ok());
}

}  // namespace
}  // namespace scanmill::render
