// SPDX-License-Identifier: Apache-2.0
// Keys beyond 32 bits: fine bins far from the origin.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/random.hpp"
#include "lattice/lattice.hpp"

namespace scanmill {
namespace {

/// Z-order by its definition: bit by bit from the highest, k before j before i, of the numbers moved to be positive.
bool before_by_bits(const BinKey& a, const BinKey& b) {
  const auto biased = [](std::int64_t v) { return static_cast<std::uint64_t>(v) + 0x8000000000000000ull; };
  const std::uint64_t x[3] = {biased(a.k), biased(a.j), biased(a.i)}, y[3] = {biased(b.k), biased(b.j), biased(b.i)};
  for (int bit = 63; bit >= 0; --bit)
    for (int axis = 0; axis < 3; ++axis) {
      const std::uint64_t one = x[axis] >> bit & 1, other = y[axis] >> bit & 1;
      if (one != other) return one < other;
    }
  return false;
}

TEST(BinKey, OrderBeyond32BitsIsThatOfTheBits) {
  Random random(5, 0, 0);
  std::vector<BinKey> keys{
      {0, 0, 0}, {-1, 0, 0}, {1ll << 32, 0, 0}, {0, 1ll << 32, 0}, {(1ll << 32) - 1, 1ll << 33, -1}};
  const auto number = [&](int bits) { return static_cast<std::int64_t>(random.next()) >> (64 - bits); };
  for (const int bits : {20, 33, 40, 51, 63})
    for (int n = 0; n < 60; ++n) keys.push_back({number(bits), number(bits), number(bits)});
  for (const BinKey& a : keys)
    for (const BinKey& b : keys) ASSERT_EQ(before(a, b), before_by_bits(a, b)) << a.i << " " << b.i;
}

TEST(Lattice, BinsOfAMicrometreAreFoundFiveKilometresAway) {
  const Lattice lattice{1.0 / 1024, {0, 0, 0}};
  for (const double far : {5e6, -5e6, 4194304.0})
    for (std::int64_t step = -3; step <= 3; ++step) {
      const Vec3 p{far + (static_cast<double>(step) + 0.5) / 1024, far, -far};
      const BinKey bin = bin_of(lattice, p);
      EXPECT_EQ(bin.i, static_cast<std::int64_t>(far) * 1024 + step);
      EXPECT_EQ(bin.k, -static_cast<std::int64_t>(far) * 1024);
      EXPECT_GT(std::abs(bin.i), 1ll << 31);
      EXPECT_EQ(centre_of(lattice, bin).x, p.x);
    }
  // An edge that is no binary fraction: a centre still lies in its own bin.
  const Lattice decimal{1e-3, {0, 0, 0}};
  for (std::int64_t i = 4'999'999'990; i < 5'000'000'010; ++i) {
    const BinKey bin{i, -i, i / 3};
    EXPECT_EQ(bin_of(decimal, centre_of(decimal, bin)), bin);
  }
}

}  // namespace
}  // namespace scanmill
