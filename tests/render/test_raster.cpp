// SPDX-License-Identifier: Apache-2.0
// Which samples a triangle covers and what is seen, against brute force.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "render/colours.hpp"
#include "render/raster.hpp"
#include "scenes.hpp"

namespace scanmill::render {
namespace {

constexpr int kWidth = 80, kHeight = 70;  // across the border of tiles of 64 pixels

/// Triangles given by corners; every one lit alike. Patch = number of the triangle.
struct Flat {
  Mesh mesh;
  Drawing drawing;
  void add(Corner a, Corner b, Corner c) {
    const auto first = static_cast<std::uint32_t>(drawing.corners.size());
    drawing.corners.insert(drawing.corners.end(), {a, b, c});
    drawing.normals.insert(drawing.normals.end(), 3, {0, 0, 1});
    mesh.positions.resize(drawing.corners.size());
    mesh.triangles.push_back({first, first + 1, first + 2});
    mesh.patch.push_back(static_cast<std::uint32_t>(mesh.triangles.size() - 1));
  }
  Image picture(Rgb front, int threads = 1) {
    drawing.mesh = &mesh;
    drawing.surface.front = drawing.surface.back = front;
    Image image(kWidth, kHeight, kPaper);
    EXPECT_TRUE(draw(drawing, image, Workers(threads).context()).ok());
    return image;
  }
};

/// The sample's centre moved by an infinitesimal step to the right and a much smaller one down, so that no edge meets
/// it: what the top-left rule means.
bool covers(const std::array<Corner, 3>& t, int sx, int sy) {
  const auto side = [&](const Corner& a, const Corner& b) {
    const std::int64_t x = ((static_cast<std::int64_t>(sx) * kGridPerSample + kGridPerSample / 2 - a.x) << 32) +
                           (1 << 16),
                       y = ((static_cast<std::int64_t>(sy) * kGridPerSample + kGridPerSample / 2 - a.y) << 32) + 1;
    return static_cast<std::int64_t>(b.x - a.x) * y - static_cast<std::int64_t>(b.y - a.y) * x > 0;
  };
  const bool first = side(t[0], t[1]);
  return side(t[1], t[2]) == first && side(t[2], t[0]) == first;
}

int samples_in_pixel(const std::array<Corner, 3>& t, int x, int y) {
  int count = 0;
  for (int k = 0; k < 4; ++k) count += covers(t, 2 * x + k % 2, 2 * y + k / 2);
  return count;
}

std::array<Corner, 3> random_triangle(Random& random, int kind) {
  std::array<Corner, 3> t;
  const double reach = kind % 3 == 0 ? 0.1 : 1;  // of the picture; small ones too
  const double x0 = random.uniform(0, 1 - reach), y0 = random.uniform(0, 1 - reach);
  for (Corner& c : t) {
    c.x = static_cast<std::int32_t>((x0 + reach * random.uniform()) * kWidth * kSamplesPerPixel * kGridPerSample);
    c.y = static_cast<std::int32_t>((y0 + reach * random.uniform()) * kHeight * kSamplesPerPixel * kGridPerSample);
    // Corners on sample centres and edges along rows of samples are the hard cases.
    if (kind % 2 == 0) {
      c.x = c.x / kGridPerSample * kGridPerSample + kGridPerSample / 2;
      c.y = c.y / kGridPerSample * kGridPerSample + kGridPerSample / 2;
    }
  }
  if (kind % 5 == 0) t[1].y = t[0].y;
  if (kind % 7 == 0) t[2].x = t[0].x;
  return t;
}

TEST(DrawTriangle, CoversTheSamplesThatBruteForceFinds) {
  const Rgb ink{120, 60, 200};
  Random random(11, 0, 0);
  for (int kind = 0; kind < 120; ++kind) {
    const auto t = random_triangle(random, kind);
    Flat flat;
    flat.add(t[0], t[1], t[2]);
    const Image image = flat.picture(ink);
    Rgb full{};  // its colour after lighting: that of a pixel covered four times
    bool known = false;
    for (int pass = 0; pass < 2; ++pass)
      for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) {
          const int count = samples_in_pixel(t, x, y);
          if (pass == 0 && count == 4 && !known) {
            full = image.pixel(x, y);
            known = true;
          }
          if (pass == 0) continue;
          if (count == 0 || known) {
            const int expected = (count * full.g + (4 - count) * 255 + 2) / 4;
            ASSERT_EQ(image.pixel(x, y).g, count == 0 ? 255 : expected) << "kind " << kind << " at " << x << "," << y;
          } else {
            ASSERT_LT(image.pixel(x, y).g, 255) << "kind " << kind << " at " << x << "," << y;
          }
        }
  }
}

TEST(DrawTriangle, NeighboursMeetWithoutGapOrOverlap) {
  Random random(12, 0, 0);
  for (int kind = 0; kind < 60; ++kind) {
    auto t = random_triangle(random, kind);
    // A fan around a point inside: three triangles that together cover what the one covers.
    const Corner inside{(t[0].x + t[1].x + t[2].x) / 3, (t[0].y + t[1].y + t[2].y) / 3, 0};
    Flat whole, fan;
    whole.add(t[0], t[1], t[2]);
    for (std::size_t k = 0; k < 3; ++k) fan.add(t[k], t[(k + 1) % 3], inside);
    EXPECT_EQ(whole.picture({90, 90, 90}), fan.picture({90, 90, 90})) << "kind " << kind;
    int twice = 0;
    for (int sy = 0; sy < 2 * kHeight; ++sy)
      for (int sx = 0; sx < 2 * kWidth; ++sx) {
        int count = 0;
        for (std::size_t k = 0; k < 3; ++k) count += covers({t[k], t[(k + 1) % 3], inside}, sx, sy);
        twice += count > 1;
      }
    EXPECT_EQ(twice, 0) << "kind " << kind;
  }
}

TEST(DrawTriangle, ShowsTheNearestWhateverTheOrder) {
  constexpr int kUnit = kSamplesPerPixel * kGridPerSample;
  const auto at = [](int x, int y, float depth) { return Corner{x * kUnit, y * kUnit, depth}; };
  const auto scene = [&](bool far_first) {
    Flat flat;
    const auto far_one = [&] { flat.add(at(2, 2, -5), at(2, 60, -5), at(60, 2, -5)); };
    const auto near_one = [&] {
      flat.add(at(2, 2, 5), at(2, 60, 5), at(60, 60, -20));
    };  // leans back through the other
    if (far_first) far_one();
    near_one();
    if (!far_first) far_one();
    flat.drawing.surface.paint = Surface::Paint::Patches;
    if (far_first) std::swap(flat.mesh.patch[0], flat.mesh.patch[1]);
    return flat.picture(kFront);
  };
  const Image image = scene(true);
  EXPECT_EQ(image, scene(false));
  // Left the near one (patch 0: blue), to the upper right the far one (patch 1: orange).
  EXPECT_GT(image.pixel(4, 30).b, image.pixel(4, 30).r);
  EXPECT_GT(image.pixel(50, 4).r, image.pixel(50, 4).b);
  EXPECT_EQ(image.pixel(70, 65), kPaper);
}

TEST(DrawTriangle, ShowsTheFirstOfEquallyNear) {
  constexpr int kUnit = kSamplesPerPixel * kGridPerSample;
  Flat flat;
  for (int k = 0; k < 2; ++k) flat.add({0, 0, 1}, {0, 60 * kUnit, 1}, {60 * kUnit, 0, 1});
  flat.drawing.surface.paint = Surface::Paint::Patches;
  const Image both = flat.picture(kFront);
  Flat first;
  first.add({0, 0, 1}, {0, 60 * kUnit, 1}, {60 * kUnit, 0, 1});
  first.drawing.surface.paint = Surface::Paint::Patches;
  EXPECT_EQ(both, first.picture(kFront));
}

TEST(DrawDot, IsHiddenBehindASurfaceUnlessLifted) {
  constexpr int kUnit = kSamplesPerPixel * kGridPerSample;
  Flat flat;
  flat.add({0, 0, 0}, {0, 70 * kUnit, 0}, {80 * kUnit, 0, 0});
  flat.drawing.dots.push_back({{40, 40, -1}, 6, 0, {1, 2, 3}});
  EXPECT_EQ(pixels_of(flat.picture(kFront), {1, 2, 3}), 0u);
  flat.drawing.dots[0].lift = 2;
  const Image image = flat.picture(kFront);
  EXPECT_EQ(image.pixel(20, 20), (Rgb{1, 2, 3}));
  EXPECT_NEAR(static_cast<double>(pixels_of(image, {1, 2, 3})), 3.14 * 9, 12);  // radius 3 pixels
}

TEST(DrawLine, HasItsWidthAndRoundEnds) {
  Drawing drawing;
  drawing.lines.push_back({{20, 40, 0}, {120, 40, 0}, 4, 0, {9, 9, 9}});
  Image image(kWidth, kHeight, kPaper);
  ASSERT_TRUE(draw(drawing, image, Workers(2).context()).ok());
  for (int x = 12; x < 58; ++x)
    for (int y = 0; y < kHeight; ++y)
      EXPECT_EQ(image.pixel(x, y), y >= 18 && y < 22 ? (Rgb{9, 9, 9}) : kPaper) << x << "," << y;
  EXPECT_EQ(image.pixel(8, 20).r < 255, true);
  EXPECT_EQ(image.pixel(7, 20), kPaper);
}

TEST(Draw, LeavesNoTraceOfTheTiles) {
  // The same things farther right and down, so that other tiles cut them: pixel for pixel the same picture.
  const auto scene = [](int shift) {
    Random random(21, 0, 0);
    Flat flat;
    const auto grid = [&](double v) { return std::floor(v * 64) / 64 + shift * kSamplesPerPixel; };
    for (int i = 0; i < 1500; ++i) {
      const double x = grid(random.uniform(0, 150)), y = grid(random.uniform(0, 130)), z = random.uniform(0, 30);
      flat.drawing.dots.push_back({{x, y, z}, 3, 0, {120, 160, 200}});
      if (i % 50 == 0) flat.drawing.lines.push_back({{x, y, z}, {x + 40, y + 9, z}, 1.5, 1, {200, 100, 50}});
      if (i % 50 == 1) {
        const auto corner = [&](double dx, double dy, double depth) {
          return Corner{static_cast<std::int32_t>((x + dx) * kGridPerSample),
                        static_cast<std::int32_t>((y + dy) * kGridPerSample), static_cast<float>(depth)};
        };
        flat.add(corner(0, 0, 3), corner(3, 50, 9), corner(50, 7, 27));
      }
    }
    flat.drawing.mesh = &flat.mesh;
    flat.drawing.surface.paint = Surface::Paint::Patches;
    flat.drawing.depth_shading = true;
    Image image(160, 150, kPaper);
    EXPECT_TRUE(draw(flat.drawing, image, Workers(2).context()).ok());
    return image;
  };
  const Image here = scene(8);
  for (const int shift : {1, 23, 47}) {
    const Image there = scene(8 + shift);
    for (int y = 0; y < 100; ++y)
      for (int x = 0; x < 110; ++x)
        ASSERT_EQ(there.pixel(x + shift, y + shift), here.pixel(x, y)) << shift << " at " << x << "," << y;
  }
}

TEST(Draw, StopsWhenAsked) {
  Flat flat;
  flat.add({0, 0, 0}, {0, 999, 0}, {999, 0, 0});
  flat.drawing.mesh = &flat.mesh;
  Workers workers;
  workers.cancel.set();
  Image image(kWidth, kHeight, kPaper);
  const auto result = draw(flat.drawing, image, workers.context());
  ASSERT_FALSE(result.ok());
  EXPECT_EQ(result.error().code, Code::Cancelled);
}

}  // namespace
}  // namespace scanmill::render
