// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "geom/vec3.hpp"

namespace scanmill {
namespace {

[[gnu::noinline]] Vec3 rounded(Vec3 p) {
  return {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)};
}

TEST(RoundingToFloat, SurvivesTheOptimiser) {
  const Vec3 p = rounded({0.1, 0.2, 0.3});
  for (const double value : {p.x, p.y, p.z}) {
    const volatile float stored = static_cast<float>(value);
    EXPECT_EQ(static_cast<double>(stored), value);
  }
}

}  // namespace
}  // namespace scanmill
