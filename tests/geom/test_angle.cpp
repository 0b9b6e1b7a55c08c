// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "base/random.hpp"
#include "geom/angle.hpp"

namespace scanmill {
namespace {

constexpr double kDegrees = 57.29577951308232;

TEST(AcosDegrees, AgreesWithTheLibrary) {
  for (int i = -20000; i <= 20000; ++i) {
    const double c = i / 20000.0;
    EXPECT_NEAR(acos_degrees(c), std::acos(c) * kDegrees, 1e-9) << c;
  }
  for (const double c : {0.5, -0.5, std::nextafter(0.5, 1), std::nextafter(-0.5, -1)})
    EXPECT_NEAR(acos_degrees(c), std::acos(c) * kDegrees, 1e-9) << c;
}

TEST(AcosDegrees, TakesRoundingBeyondOne) {
  EXPECT_EQ(acos_degrees(1 + 1e-12), 0);
  EXPECT_EQ(acos_degrees(-1 - 1e-12), 180);
}

TEST(DegreesOfChord, IsTheAngleBetweenUnitVectors) {
  for (int i = 0; i <= 18000; ++i) {
    const double angle = i / 100.0, chord = 2 * std::sin(angle / kDegrees / 2);
    EXPECT_NEAR(degrees_of_chord(chord), angle, i < 17900 ? 1e-9 : 1e-5) << angle;  // steep at the far end
  }
  EXPECT_EQ(degrees_of_chord(0), 0);
  EXPECT_EQ(degrees_of_chord(2.5), 180);
}

TEST(DegreesOfChord, KeepsSmallAngles) { EXPECT_NEAR(degrees_of_chord(1e-9) / kDegrees, 1e-9, 1e-24); }

TEST(DegreesOfChord, NeverFalls) {
  Random random(5, 6, 7);
  for (int i = 0; i < 10000; ++i) {
    const double chord = 2 * random.uniform(), more = std::nextafter(chord, 3) + 1e-9 * random.uniform();
    EXPECT_LE(degrees_of_chord(chord), degrees_of_chord(more) + 1e-12);
  }
}

}  // namespace
}  // namespace scanmill
