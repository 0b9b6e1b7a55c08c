// SPDX-License-Identifier: Apache-2.0
// What `reduce` writes comes back bit by bit; what it does not write is refused, whatever bytes stand there.
#include <gtest/gtest.h>

#include <bit>
#include <limits>

#include "base/context.hpp"
#include "base/random.hpp"
#include "cloud/cloud.hpp"
#include "pipeline/reduced_file.hpp"

namespace scanmill::pipeline {
namespace {

constexpr std::size_t kColumns = 21;

std::string written() {
  Random random(1, 2, 3);
  std::vector<Vec3> points;
  for (int i = 0; i < 500; ++i) points.push_back({random.uniform(0, 8), random.uniform(0, 8), random.uniform(0, 0.2)});
  reduce::LatticeParams lattice;
  lattice.bin_mm = 1;
  const ChunkLoop loop(1);
  const CancelFlag cancel;
  auto reduction = reduce::reduce_cloud(MemoryPoints(points), lattice, {}, {loop, cancel});
  std::string bytes;
  auto sink = memory_sink("x.ply", bytes);
  EXPECT_TRUE(write_reduced(reduction->cloud, *sink).ok());
  EXPECT_TRUE(sink->commit().ok());
  return bytes;
}

/// The file with `value` in this column of its last bin.
std::string with_value(std::string bytes, std::size_t column, double value) {
  auto bits = std::bit_cast<std::uint64_t>(value);
  const std::size_t at = bytes.size() - (kColumns - column) * 8;
  for (std::size_t k = 0; k < 8; ++k, bits >>= 8) bytes[at + k] = static_cast<char>(bits & 0xff);
  return bytes;
}

TEST(ReducedFile, ComesBackToTheLastBit) {
  const std::string bytes = written();
  const auto cloud = read_reduced(*memory_source("x.ply", bytes));
  ASSERT_TRUE(cloud.ok()) << cloud.error().text();
  std::string again;
  auto sink = memory_sink("y.ply", again);
  ASSERT_TRUE(write_reduced(*cloud, *sink).ok());
  ASSERT_TRUE(sink->commit().ok());
  EXPECT_EQ(again, bytes);
}

TEST(ReducedFile, RefusesNumbersThatReduceDoesNotWrite) {
  const std::string bytes = written();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t column = 0; column < 19; ++column)  // the last two are flags: anything but 0 is set
    for (const double value : {nan, 1e300, -1e300}) {
      const auto cloud = read_reduced(*memory_source("x.ply", with_value(bytes, column, value)));
      ASSERT_FALSE(cloud.ok()) << "column " << column << " value " << value;
      EXPECT_EQ(cloud.error().code, Code::BadInput);
    }
}

TEST(ReducedFile, RefusesALatticeThatIsNone) {
  const std::string bytes = written();
  auto with = [&](const std::string& from, const std::string& to) {
    std::string changed = bytes;
    changed.replace(changed.find(from), from.size(), to);
    return read_reduced(*memory_source("x.ply", changed)).ok();
  };
  EXPECT_TRUE(with("bin_mm 1\n", "bin_mm 1.0\n"));
  EXPECT_FALSE(with("bin_mm 1\n", "bin_mm inf\n"));
  EXPECT_FALSE(with("bin_mm 1\n", "bin_mm -1\n"));
  EXPECT_FALSE(with("origin_mm 0 0 0\n", "origin_mm 0 nan 0\n"));
  EXPECT_FALSE(with("base 0 0 0\n", "base 1e300 0 0\n"));
}

}  // namespace
}  // namespace scanmill::pipeline
