// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "base/random.hpp"
#include "lattice/bin_index.hpp"

namespace scanmill {
namespace {

/// Clumps around corners of leaves and of the tree's upper nodes (8, 128, 4096), on both sides of zero.
std::vector<LocalBin> bins_at_borders(std::uint64_t seed, std::size_t count) {
  Random random(seed, count, 0);
  constexpr std::int32_t kCorners[] = {0, 8, -8, 128, -128, 4096, -4096, 1 << 29, -(1 << 29)};
  std::vector<LocalBin> bins(count);
  for (LocalBin& bin : bins) {
    const std::size_t clump = random.next() % 9;
    for (std::int32_t& number : bin) number = kCorners[clump] + static_cast<std::int32_t>(random.next() % 12) - 6;
  }
  return bins;
}

using Map = std::map<LocalBin, std::int32_t>;  // i, then j, then k: the order in which windows are told

struct Indexed {
  std::vector<LocalBin> bins;
  Map rows;
  BinIndex index;
};

Indexed indexed(std::uint64_t seed) {
  Indexed out;
  BinTree tree;
  const auto bins = bins_at_borders(seed, 6000);
  std::vector<std::int32_t> slots(bins.size());
  tree.slots_of(bins, slots);
  for (const auto& entry : tree.sorted({})) {
    out.rows[entry.bin] = static_cast<std::int32_t>(out.bins.size());
    out.bins.push_back(entry.bin);
  }
  out.index = BinIndex::over(out.bins);
  return out;
}

/// Places worth asking about: occupied, near, and far from everything.
std::vector<LocalBin> places(const Indexed& it, std::uint64_t seed) {
  auto asked = bins_at_borders(seed, 300);
  asked.insert(asked.end(), it.bins.begin(), it.bins.begin() + 100);
  asked.push_back({1000, 1000, 1000});
  return asked;
}

TEST(BinTree, GivesEachBinOneSlotInOrderOfFirstSight) {
  BinTree tree;
  Map seen;
  for (const std::uint64_t seed : {1, 2, 1}) {
    const auto bins = bins_at_borders(seed, 3000);
    std::vector<std::int32_t> slots(bins.size(), -7);
    tree.slots_of(bins, slots);
    for (std::size_t n = 0; n < bins.size(); ++n) {
      const auto next = static_cast<std::int32_t>(seen.size());
      ASSERT_EQ(slots[n], seen.emplace(bins[n], next).first->second);
    }
    EXPECT_EQ(tree.size(), std::ssize(seen));
  }
}

TEST(BinTree, SortsBinsByTheirKeys) {
  for (const BinKey base : {BinKey{}, BinKey{-1024, 1024, 5 << 20}, BinKey{8, -8, 16}}) {
    BinTree tree;
    const auto bins = bins_at_borders(3, 5000);
    std::vector<std::int32_t> slots(bins.size());
    tree.slots_of(bins, slots);
    Map slot_of;
    for (std::size_t n = 0; n < bins.size(); ++n) slot_of[bins[n]] = slots[n];
    const auto entries = tree.sorted(base);
    ASSERT_EQ(entries.size(), slot_of.size());
    auto key_of = [&](const LocalBin& b) { return BinKey{base.i + b[0], base.j + b[1], base.k + b[2]}; };
    for (std::size_t n = 0; n < entries.size(); ++n) {
      ASSERT_EQ(slot_of.at(entries[n].bin), entries[n].slot);
      if (n > 0) {
        ASSERT_TRUE(before(key_of(entries[n - 1].bin), key_of(entries[n].bin)));
      }
    }
  }
}

TEST(BinTree, IsEmptyAtFirst) {
  const BinTree tree;
  EXPECT_EQ(tree.size(), 0);
  EXPECT_TRUE(tree.sorted({}).empty());
}

TEST(BinIndexReader, FindsRowsOneByOneAndManyAtOnce) {
  const Indexed it = indexed(4);
  BinIndex::Reader reader(it.index);
  const auto asked = places(it, 5);
  std::vector<std::int32_t> rows(asked.size(), -7);
  reader.rows_of(asked, rows);
  int found = 0;
  for (std::size_t n = 0; n < asked.size(); ++n) {
    const auto at = it.rows.find(asked[n]);
    const std::int32_t expected = at == it.rows.end() ? kNoSlot : at->second;
    ASSERT_EQ(rows[n], expected);
    ASSERT_EQ(reader.row_at(asked[n]), expected);
    found += expected != kNoSlot;
  }
  EXPECT_GT(found, 100);
  EXPECT_LT(found, std::ssize(asked));
}

TEST(BinIndexReader, WindowsEqualASearchOverAllBins) {
  const Indexed it = indexed(6);
  BinIndex::Reader reader(it.index);
  for (const LocalBin& centre : places(it, 7))
    for (const int radius : {0, 1, 2, 8}) {
      std::vector<std::int32_t> rows{-5};  // what is there already stays
      std::vector<BinIndex::Reader::Neighbour> around;
      reader.window(centre, radius, rows);
      reader.window(centre, radius, around);
      std::vector<std::int32_t> expected{-5};
      for (const auto& [bin, row] : it.rows) {
        const std::int64_t d[3] = {std::int64_t{bin[0]} - centre[0], std::int64_t{bin[1]} - centre[1],
                                   std::int64_t{bin[2]} - centre[2]};
        if (std::max({std::abs(d[0]), std::abs(d[1]), std::abs(d[2])}) > radius) continue;
        ASSERT_LT(expected.size() - 1, around.size());
        const auto& near = around[expected.size() - 1];
        ASSERT_TRUE(near.row == row && near.di == d[0] && near.dj == d[1] && near.dk == d[2]);
        expected.push_back(row);
      }
      ASSERT_EQ(rows, expected) << "radius " << radius;
      ASSERT_EQ(around.size() + 1, expected.size());
    }
}

TEST(BinIndexReader, BoxesEqualASearchOverAllBins) {
  const Indexed it = indexed(8);
  BinIndex::Reader reader(it.index);
  Random random(9, 9, 9);
  for (const LocalBin& low : places(it, 10)) {
    LocalBin high = low;
    for (std::int32_t& number : high) number += static_cast<std::int32_t>(random.next() % 9);
    std::vector<std::int32_t> rows, expected;
    reader.box(low, high, rows);
    for (const auto& [bin, row] : it.rows)
      if (bin[0] >= low[0] && bin[1] >= low[1] && bin[2] >= low[2] && bin[0] <= high[0] && bin[1] <= high[1] &&
          bin[2] <= high[2])
        expected.push_back(row);
    ASSERT_EQ(rows, expected);
  }
}

TEST(BinIndexReader, FindsNothingInAnEmptyIndex) {
  const BinIndex index = BinIndex::over({});
  BinIndex::Reader reader(index);
  std::vector<std::int32_t> rows;
  reader.window({0, 0, 0}, 2, rows);
  reader.box({0, 0, 0}, {3, 3, 3}, rows);
  EXPECT_TRUE(rows.empty());
  EXPECT_EQ(reader.row_at({0, 0, 0}), kNoSlot);
}

}  // namespace
}  // namespace scanmill
