// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "store/bin_grids.hpp"

namespace scanmill::store {
namespace {

Result<std::string> written(const std::vector<BinKey>& bins, const std::vector<std::int32_t>& values) {
  std::string bytes;
  const auto sink = memory_sink("bins.vdb", bytes);
  const BinColumn columns[] = {{"points", "points in the bin", values}};
  TRY(write_bin_grids({0.5, {1, 2, 3}}, bins, columns, *sink));
  TRY(sink->commit());
  return bytes;
}

TEST(BinGrids, AreTheSameBytesTwiceWithAnIdentifierOfTheContent) {
  const std::vector<BinKey> bins{{0, 0, 0}, {5, -7, 100}, {-3000, 9, 12}};
  const auto a = written(bins, {1, 2, 3}), b = written(bins, {1, 2, 3}), c = written(bins, {1, 2, 4});
  ASSERT_TRUE(a.ok() && b.ok() && c.ok());
  EXPECT_EQ(*a, *b);
  EXPECT_NE(a->substr(21, 36), c->substr(21, 36));
  EXPECT_EQ((*a)[29], '-');
  EXPECT_EQ(a->substr(0, 4), std::string(" BDV", 4));
}

TEST(BinGrids, RefuseKeysBeyondWhatVoxelsAreNumberedBy) {
  const auto far = written({{std::int64_t{1} << 40, 0, 0}}, {1});
  ASSERT_FALSE(far.ok());
  EXPECT_EQ(far.error().code, Code::Unsupported);
  EXPECT_EQ(written({{0, 0, 0}}, {}).error().code, Code::Internal);
}

}  // namespace
}  // namespace scanmill::store
