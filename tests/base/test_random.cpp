// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "base/random.hpp"

namespace scanmill {
namespace {

TEST(Mix64, IsTheFinaliserOfSplitmix64) {
  // First numbers of splitmix64 from seed 0 as published with it.
  EXPECT_EQ(mix64(0), 0xe220a8397b1dcdafull);
  EXPECT_EQ(mix64(0x9e3779b97f4a7c15ull), 0x6e789e6aa1b965f4ull);
}

TEST(Random, DependsOnSeedKeyAndPurposeAlone) {
  std::set<std::uint64_t> first;
  for (std::uint64_t seed = 0; seed < 4; ++seed)
    for (std::uint64_t key = 0; key < 4; ++key)
      for (std::uint64_t purpose = 0; purpose < 4; ++purpose) first.insert(Random(seed, key, purpose).next());
  EXPECT_EQ(first.size(), 64u);
  Random a(1, 2, 3), b(1, 2, 3);
  for (int n = 0; n < 10; ++n) EXPECT_EQ(a.next(), b.next());
}

TEST(Random, UniformsFillTheirInterval) {
  Random random(1, 1, 1);
  double sum = 0, low = 1, high = 0;
  for (int n = 0; n < 100000; ++n) {
    const double u = random.uniform();
    ASSERT_GE(u, 0);
    ASSERT_LT(u, 1);
    sum += u;
    low = std::min(low, u);
    high = std::max(high, u);
  }
  EXPECT_NEAR(sum / 100000, 0.5, 0.005);
  EXPECT_LT(low, 1e-3);
  EXPECT_GT(high, 1 - 1e-3);
}

TEST(Random, GaussHasMeanZeroAndVarianceOne) {
  Random random(2, 1, 1);
  double sum = 0, squares = 0, fourths = 0;
  constexpr int kCount = 200000;
  for (int n = 0; n < kCount; ++n) {
    const double g = random.gauss();
    ASSERT_LE(std::abs(g), 6);
    sum += g;
    squares += g * g;
    fourths += g * g * g * g;
  }
  EXPECT_NEAR(sum / kCount, 0, 0.01);
  EXPECT_NEAR(squares / kCount, 1, 0.02);
  EXPECT_NEAR(fourths / kCount, 2.9, 0.1);
}

}  // namespace
}  // namespace scanmill
