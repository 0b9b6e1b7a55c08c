// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "mesh/section_drawing.hpp"

namespace scanmill {
namespace {

Section line_between(Uv a, Uv b, double slab_mm) {
  Section section;
  section.frame.slab_mm = slab_mm;
  section.lines.push_back({{a, b}, false});
  return section;
}

TEST(DrawnBounds, OfADotAreNoSmallerThanTheSlab) {
  const DrawnBounds dot = drawn_bounds(line_between({7, 3}, {7, 3 + 1e-9}, 0.5));
  EXPECT_DOUBLE_EQ(dot.low.u, 6.5);
  EXPECT_DOUBLE_EQ(dot.high.u, 7.5);
  const DrawnBounds line = drawn_bounds(line_between({7, 3}, {7, 30}, 0.5));
  EXPECT_EQ(line.low.u, line.high.u);
  EXPECT_DOUBLE_EQ(line.high.v, 30);
  EXPECT_TRUE(drawn_bounds(Section{}).empty());
}

}  // namespace
}  // namespace scanmill
