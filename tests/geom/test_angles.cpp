// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "base/random.hpp"
#include "geom/angles.hpp"

namespace scanmill {
namespace {

constexpr long double kDegrees = 57.295779513082320876798154814105170L;

TEST(DegreesOf, IsTheArcTangent) {
  for (double x = 0; x <= 180; x += 0.0017) {
    const double sine = static_cast<double>(std::sin(x / kDegrees)),
                 cosine = static_cast<double>(std::cos(x / kDegrees));
    ASSERT_NEAR(
        degrees_of(sine, cosine),
        static_cast<double>(std::atan2(static_cast<long double>(sine), static_cast<long double>(cosine)) * kDegrees),
        1e-13)
        << x;
  }
}

TEST(DegreesOf, KeepsSmallAnglesToTheLastDigits) {
  for (double sine = 1e-300; sine < 1e-3; sine *= 7)
    ASSERT_NEAR(degrees_of(sine, 1) / static_cast<double>(std::atan(static_cast<long double>(sine)) * kDegrees), 1,
                1e-15);
}

TEST(DegreesOf, IsExactAtTheQuarters) {
  EXPECT_EQ(degrees_of(0, 0), 0);
  EXPECT_EQ(degrees_of(0, 3), 0);
  EXPECT_EQ(degrees_of(2, 0), 90);
  EXPECT_EQ(degrees_of(0, -3), 180);
  EXPECT_EQ(degrees_of(5, 5), 45);
}

TEST(AcosDegrees, IsTheArcCosine) {
  for (int n = -100000; n <= 100000; ++n) {
    const double c = n / 100000.0;
    ASSERT_NEAR(acos_degrees(c), static_cast<double>(std::acos(static_cast<long double>(c)) * kDegrees), 1e-9) << c;
  }
  EXPECT_EQ(acos_degrees(1.5), 0);
  EXPECT_EQ(acos_degrees(-1.5), 180);
}

TEST(DegreesBetween, DoesNotDependOnLengths) {
  Random random(1, 2, 3);
  for (int n = 0; n < 1000; ++n) {
    const Vec3 u{random.gauss(), random.gauss(), random.gauss()}, v{random.gauss(), random.gauss(), random.gauss()};
    ASSERT_NEAR(degrees_between(u, v), degrees_between(u * 1e-20, v * 1e20), 1e-12);
    ASSERT_NEAR(degrees_between(u, v) + degrees_between(u, -v), 180, 1e-12);
  }
  EXPECT_EQ(degrees_between({}, {1, 0, 0}), 0);
}

constexpr double kPerRadian = 57.29577951308232;

TEST(DegreesOfChord, IsTheAngleBetweenUnitVectors) {
  for (int i = 0; i <= 18000; ++i) {
    const double angle = i / 100.0, chord = 2 * std::sin(angle / kPerRadian / 2);
    EXPECT_NEAR(degrees_of_chord(chord), angle, i < 17900 ? 1e-9 : 1e-5) << angle;  // steep at the far end
  }
  EXPECT_EQ(degrees_of_chord(0), 0);
  EXPECT_EQ(degrees_of_chord(2.5), 180);
}

TEST(DegreesOfChord, KeepsSmallAngles) { EXPECT_NEAR(degrees_of_chord(1e-9) / kPerRadian, 1e-9, 1e-24); }

TEST(DegreesOfChord, NeverFalls) {
  Random random(5, 6, 7);
  for (int i = 0; i < 10000; ++i) {
    const double chord = 2 * random.uniform(), more = std::nextafter(chord, 3) + 1e-9 * random.uniform();
    EXPECT_LE(degrees_of_chord(chord), degrees_of_chord(more) + 1e-12);
  }
}

}  // namespace
}  // namespace scanmill
