// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "base/random.hpp"
#include "lattice/lattice.hpp"

namespace scanmill {
namespace {

__extension__ using Code = unsigned __int128;

/// Numbers of 21 bits, shifted to be positive, interleaved bit by bit: k most significant, then j, then i.
Code interleaved(const BinKey& key) {
  constexpr std::int64_t kShift = 1 << 20;
  Code code = 0;
  for (int bit = 20; bit >= 0; --bit)
    for (const std::int64_t number : {key.k, key.j, key.i})
      code = code << 1 | static_cast<Code>(((number + kShift) >> bit) & 1);
  return code;
}

/// Wide, narrow and nearly equal numbers on both sides of zero.
BinKey random_key(Random& random) {
  const std::uint64_t size = std::uint64_t{1} << (1 + random.next() % 20);
  auto number = [&] { return static_cast<std::int64_t>(random.next() % (2 * size)) - static_cast<std::int64_t>(size); };
  const std::int64_t i = number(), j = number(), k = number();
  return {i, j, k};
}

TEST(BinKey, OrderIsThatOfInterleavedBits) {
  Random random(1, 2, 3);
  for (int n = 0; n < 200000; ++n) {
    const BinKey a = random_key(random), b = n % 7 == 0 ? a : random_key(random);
    ASSERT_EQ(before(a, b), interleaved(a) < interleaved(b))
        << a.i << ' ' << a.j << ' ' << a.k << " and " << b.i << ' ' << b.j << ' ' << b.k;
  }
}

TEST(BinKey, OrderIsStrictAndTotalAtTheEndsOfTheRange) {
  constexpr std::int64_t kLow = INT64_MIN, kHigh = INT64_MAX;
  std::vector<BinKey> keys;
  for (const std::int64_t i : {kLow, std::int64_t{-1}, std::int64_t{0}, kHigh})
    for (const std::int64_t j : {kLow, std::int64_t{-1}, std::int64_t{0}, kHigh})
      for (const std::int64_t k : {kLow, std::int64_t{-1}, std::int64_t{0}, kHigh}) keys.push_back({i, j, k});
  for (const BinKey& a : keys)
    for (const BinKey& b : keys) {
      ASSERT_EQ(before(a, b) + before(b, a), a == b ? 0 : 1);
      for (const BinKey& c : keys)
        if (before(a, b) && before(b, c)) {
          ASSERT_TRUE(before(a, c));
        }
    }
}

TEST(BinKey, BricksOfPowersOfTwoAreRunsOfKeys) {
  std::vector<BinKey> keys;
  for (std::int64_t i = -8; i < 8; ++i)
    for (std::int64_t j = -8; j < 8; ++j)
      for (std::int64_t k = -8; k < 8; ++k) keys.push_back({i, j, k});
  std::sort(keys.begin(), keys.end(), [](const BinKey& a, const BinKey& b) { return before(a, b); });
  for (const std::int64_t brick : {2, 4, 8}) {
    const auto run = static_cast<std::size_t>(brick * brick * brick);
    for (std::size_t n = 0; n < keys.size(); ++n) {
      const BinKey& first = keys[n / run * run];
      ASSERT_EQ(first.i & (brick - 1), 0);
      ASSERT_EQ(keys[n].i & ~(brick - 1), first.i);
      ASSERT_EQ(keys[n].j & ~(brick - 1), first.j);
      ASSERT_EQ(keys[n].k & ~(brick - 1), first.k);
    }
  }
}

TEST(Lattice, BinsAreHalfOpen) {
  const Lattice lattice{0.5, {1, 2, 3}};
  EXPECT_EQ(bin_of(lattice, {1, 2, 3}), (BinKey{0, 0, 0}));
  EXPECT_EQ(bin_of(lattice, {1.5, 2.5, 3.5}), (BinKey{1, 1, 1}));
  EXPECT_EQ(bin_of(lattice, {1 - 1e-9, 2, 3}), (BinKey{-1, 0, 0}));
  EXPECT_EQ(bin_of(lattice, {0.5, 1.5, 2.5}), (BinKey{-1, -1, -1}));
  EXPECT_EQ(bin_of(lattice, {-0.25, 0, 0}), (BinKey{-3, -4, -6}));
  const double below = std::nextafter(1.5, 0);
  EXPECT_EQ(bin_of(lattice, {below, 2, 3}), (BinKey{0, 0, 0}));
}

TEST(Lattice, CentresLieInTheirBins) {
  Random random(4, 5, 6);
  for (int n = 0; n < 2000; ++n) {
    const Lattice lattice{random.uniform(0.1, 3), {random.uniform(-9, 9), random.uniform(-9, 9), 5.4e6}};
    const BinKey key = random_key(random);
    ASSERT_EQ(bin_of(lattice, centre_of(lattice, key)), key);
  }
}

}  // namespace
}  // namespace scanmill
