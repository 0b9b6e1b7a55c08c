// SPDX-License-Identifier: Apache-2.0
// Numbers, scales and letters around the part.
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "render/colours.hpp"
#include "render/glyphs.hpp"
#include "render/overlay.hpp"
#include "render/strokes.hpp"
#include "scenes.hpp"

namespace scanmill::render {
namespace {

TEST(Rounded125, TakesTheNextStepUpAndDown) {
  EXPECT_EQ(rounded_up_125(0.03), 0.05);
  EXPECT_EQ(rounded_up_125(0.05), 0.05);
  EXPECT_EQ(rounded_up_125(0.0501), 0.1);
  EXPECT_EQ(rounded_up_125(1), 1);
  EXPECT_EQ(rounded_up_125(1.01), 2);
  EXPECT_EQ(rounded_up_125(1e6), 1e6);
  EXPECT_EQ(rounded_up_125(0), 0.001);
  EXPECT_EQ(rounded_up_125(-1), 0.001);
  EXPECT_EQ(rounded_down_125(0.09), 0.05);
  EXPECT_EQ(rounded_down_125(10), 10);
  EXPECT_EQ(rounded_down_125(19.9), 10);
  EXPECT_EQ(rounded_down_125(1e150 * 3) > 1e150, true);
}

TEST(AutomaticErrorRange, IsTheNinetyNinthPercentileRoundedUp) {
  std::vector<double> errors;
  for (int i = 1; i <= 1000; ++i) errors.push_back((i % 2 ? 1 : -1) * i * 1e-4);  // p99: 0.099
  errors.push_back(NAN);
  EXPECT_EQ(automatic_error_range(errors), 0.1);
  errors.push_back(1e9);
  EXPECT_EQ(automatic_error_range(errors), 0.1);
  EXPECT_EQ(automatic_error_range({}), 0.001);
  EXPECT_EQ(automatic_error_range(std::vector<double>{0, NAN}), 0.001);
}

TEST(LengthText, HasTheDecimalsOfItsStepAndGroups) {
  EXPECT_EQ(length_text(0.05, 0.025), "0.050");
  EXPECT_EQ(length_text(-0.025, 0.025), "-0.025");
  EXPECT_EQ(length_text(20, 20), "20");
  EXPECT_EQ(length_text(2000, 2000), "2,000");
  EXPECT_EQ(length_text(1234567, 1), "1,234,567");
  EXPECT_EQ(length_text(0, 0.5), "0.0");
  EXPECT_EQ(length_text(2e140, 2e140), "2e+140");
}

TEST(ErrorScale, RunsFromBlueOverWhiteToRedAndMarksWhatIsBeyond) {
  const ErrorScale scale;
  const auto grey = [](Rgb c) { return 0.3 * c.r + 0.59 * c.g + 0.11 * c.b; };
  EXPECT_GT(scale.at(-1).b, scale.at(-1).r + 80);
  EXPECT_GT(scale.at(1).r, scale.at(1).b + 80);
  EXPECT_GT(grey(scale.at(0)), 240);
  for (double t = 0; t < 0.99; t += 0.01) {
    EXPECT_GE(grey(scale.at(t)), grey(scale.at(t + 0.01)));
    EXPECT_GE(grey(scale.at(-t)), grey(scale.at(-t - 0.01)));
    EXPECT_NEAR(grey(scale.at(t)), grey(scale.at(-t)), 26);  // both signs equally strong
  }
  EXPECT_EQ(scale.at(1.001), ErrorScale::kAbove);
  EXPECT_EQ(scale.at(-1e300), ErrorScale::kBelow);
  EXPECT_EQ(scale.at(NAN), kUnknown);
}

TEST(PatchColour, DiffersForThirtyPatchesAndFromPaper) {
  std::set<std::tuple<int, int, int>> seen;
  for (std::uint32_t p = 0; p < 30; ++p) {
    const Rgb c = patch_colour(p);
    seen.insert({c.r, c.g, c.b});
    EXPECT_LT(std::min({c.r, c.g, c.b}), 225) << p;
  }
  EXPECT_EQ(seen.size(), 30u);
}

TEST(Glyphs, AreStrokesOnTheGridAndNoTwoAlike) {
  std::set<std::string> seen;
  for (char32_t c = 33; c < 127; ++c) {
    const Glyph g = glyph_of(c);
    ASSERT_EQ(g.strokes.size() % 3, 2u) << static_cast<int>(c);
    for (std::size_t i = 0; i < g.strokes.size(); i += 3) {
      EXPECT_LE(g.strokes[i] - '0', g.width) << static_cast<int>(c);
      EXPECT_LE(g.strokes[i + 1], '8');
      EXPECT_GE(g.strokes[i + 1], '0');
      EXPECT_TRUE(i + 2 >= g.strokes.size() || g.strokes[i + 2] == ' ' || g.strokes[i + 2] == ',');
    }
    seen.insert(std::string(g.strokes));
  }
  EXPECT_EQ(seen.size(), 93u);  // O and 0 are one shape
}

TEST(DrawText, StaysInItsWidthAndSkipsWhatIsOutside) {
  Image image(200, 40, kPaper);
  const std::string text = "fit +0.05 mm";
  draw_text(image, 10, 30, text, 12, kInk);
  const double width = text_width(text, 12);
  std::size_t inside = 0;
  for (int y = 0; y < 40; ++y)
    for (int x = 0; x < 200; ++x) {
      if (image.pixel(x, y) == kPaper) continue;
      ++inside;
      EXPECT_TRUE(x >= 8 && x <= 12 + width && y >= 16 && y <= 35) << x << "," << y;
    }
  EXPECT_GT(inside, 200u);
  Image small(10, 10, kPaper);
  draw_text(small, -500, 1e6, text, 12, kInk);
  draw_text(small, 5, 5, "\xff\xc3(\xe2\x82", 1000, kInk);  // no UTF-8
  EXPECT_EQ(pixels_of(Image(10, 10, kPaper), kPaper), 100u);
}

TEST(TextWithin, CutsBetweenCharacters) {
  EXPECT_EQ(text_within("short", 10, 1000), "short");
  const std::string cut = text_within("\xc2\xb5\xc2\xb5\xc2\xb5\xc2\xb5\xc2\xb5\xc2\xb5\xc2\xb5\xc2\xb5", 10, 40);
  EXPECT_LE(text_width(cut, 10), 40);
  EXPECT_EQ(cut.substr(cut.size() - 3), "...");
  EXPECT_EQ((cut.size() - 3) % 2, 0u);
}

TEST(LayoutOf, KeepsStripsApartAtEverySize) {
  for (const auto& [w, h] : {std::pair{320, 240}, {640, 480}, {1280, 960}, {4000, 500}, {500, 4000}})
    for (int kind = 0; kind < 4; ++kind) {
      const Layout l = layout_of(w, h, kind % 2 == 1, kind / 2 == 1 ? 0.0001 : 0);
      EXPECT_GE(l.part.top, l.title.top + l.title.height);
      EXPECT_LE(l.part.top + l.part.height, l.strip.top);
      EXPECT_LE(l.part.left + l.part.width, l.legend.left + 1e-9);
      EXPECT_LE(l.strip.top + l.strip.height, h);
      EXPECT_GT(l.part.width, 30);
      EXPECT_GT(l.part.height, 30);
    }
}

}  // namespace
}  // namespace scanmill::render
