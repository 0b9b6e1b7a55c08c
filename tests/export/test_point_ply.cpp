// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cstring>
#include <limits>

#include "export/writers.hpp"

namespace scanmill::exporting {
namespace {

PointBlock block_of(std::uint32_t view, std::vector<Vec3> positions, std::uint64_t first_row) {
  PointBlock block;
  block.view = ViewId{view};
  block.positions = std::move(positions);
  for (std::size_t i = 0; i < block.positions.size(); ++i) block.rows.push_back(first_row + i);
  return block;
}

template <class T>
T value_at(const std::string& bytes, std::size_t at) {
  T value{};
  EXPECT_LE(at + sizeof value, bytes.size());
  if (at + sizeof value <= bytes.size()) std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

TEST(PlyPointWriter, WritesHeaderAndRecordsAsAnnounced) {
  std::string bytes;
  const auto sink = memory_sink("cloud.ply", bytes);
  const std::vector<std::string> comments{"made of two views", "a name\nwith a line break"};
  auto writer = PlyPointWriter::begin(*sink, 3, comments);
  ASSERT_TRUE(writer.ok());
  ASSERT_TRUE(writer->add(block_of(7, {{0.1, -0.0, 1e-300}, {4, 5, 6}}, 10)).ok());
  ASSERT_TRUE(writer->add(block_of(8, {{7, 8, 9}}, std::uint64_t{1} << 40)).ok());
  ASSERT_TRUE(writer->finish().ok());
  EXPECT_TRUE(bytes.empty()) << "finish must leave the commit to the caller";
  ASSERT_TRUE(sink->commit().ok());
  const std::string header =
      "ply\nformat binary_little_endian 1.0\ncomment made of two views\ncomment a name with a line break\n"
      "element vertex 3\nproperty double x\nproperty double y\nproperty double z\nproperty uint view\n"
      "property double row\nend_header\n";
  ASSERT_EQ(bytes.substr(0, header.size()), header);
  ASSERT_EQ(bytes.size(), header.size() + 3 * 36);
  EXPECT_EQ(value_at<double>(bytes, header.size()), 0.1);
  EXPECT_FALSE(std::signbit(value_at<double>(bytes, header.size() + 8)));
  EXPECT_EQ(value_at<double>(bytes, header.size() + 16), 1e-300);
  EXPECT_EQ(value_at<std::uint32_t>(bytes, header.size() + 24), 7u);
  EXPECT_EQ(value_at<double>(bytes, header.size() + 36 + 28), 11);
  EXPECT_EQ(value_at<std::uint32_t>(bytes, header.size() + 72 + 24), 8u);
  EXPECT_EQ(value_at<double>(bytes, header.size() + 72 + 28), 1099511627776.0);
}

TEST(PlyPointWriter, KeepsEveryPointOverManyBuffers) {
  std::string bytes;
  const auto sink = memory_sink("cloud.ply", bytes);
  constexpr std::uint64_t kPerBlock = 7001, kBlocks = 9;
  auto writer = PlyPointWriter::begin(*sink, kPerBlock * kBlocks, {});
  ASSERT_TRUE(writer.ok());
  for (std::uint64_t b = 0; b < kBlocks; ++b) {
    std::vector<Vec3> positions;
    for (std::uint64_t i = 0; i < kPerBlock; ++i) positions.push_back({static_cast<double>(b * kPerBlock + i), 0, 0});
    ASSERT_TRUE(writer->add(block_of(0, positions, 0)).ok());
  }
  ASSERT_TRUE(writer->finish().ok());
  ASSERT_TRUE(sink->commit().ok());
  const std::size_t start = bytes.find("end_header\n") + 11;
  ASSERT_EQ(bytes.size(), start + 36 * kPerBlock * kBlocks);
  for (std::uint64_t i = 0; i < kPerBlock * kBlocks; ++i)
    ASSERT_EQ(value_at<double>(bytes, start + 36 * i), static_cast<double>(i));
}

TEST(PlyPointWriter, RefusesMoreOrFewerPointsThanAnnounced) {
  std::string bytes;
  const auto sink = memory_sink("cloud.ply", bytes);
  auto writer = PlyPointWriter::begin(*sink, 2, {});
  ASSERT_TRUE(writer.ok());
  ASSERT_TRUE(writer->add(block_of(0, {{1, 2, 3}}, 0)).ok());
  const auto fewer = writer->finish();
  ASSERT_FALSE(fewer.ok());
  EXPECT_EQ(fewer.error().code, Code::Internal);
  EXPECT_EQ(fewer.error().where, "cloud.ply");
  const auto more = writer->add(block_of(0, {{1, 2, 3}, {1, 2, 3}}, 1));
  ASSERT_FALSE(more.ok());
  EXPECT_EQ(more.error().code, Code::Internal);
}

TEST(WriteViewPly, LeavesEmptyCellsOutAndKeepsFloatsBitForBit) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  const double third = static_cast<double>(1.0f / 3.0f);
  const std::vector<Vec3> cells{{nan, nan, nan}, {third, -0.0, 150}, {nan, nan, nan}, {1, 2, 3}};
  std::string bytes;
  const auto sink = memory_sink("view.ply", bytes);
  const std::vector<std::string> comments{"object cube"};
  ASSERT_TRUE(write_view_ply(cells, comments, *sink).ok());
  ASSERT_TRUE(sink->commit().ok());
  const std::string header =
      "ply\nformat binary_little_endian 1.0\ncomment object cube\nelement vertex 2\nproperty float x\n"
      "property float y\nproperty float z\nend_header\n";
  ASSERT_EQ(bytes.substr(0, header.size()), header);
  ASSERT_EQ(bytes.size(), header.size() + 2 * 12);
  EXPECT_EQ(value_at<float>(bytes, header.size()), 1.0f / 3.0f);
  EXPECT_FALSE(std::signbit(value_at<float>(bytes, header.size() + 4)));
  EXPECT_EQ(value_at<float>(bytes, header.size() + 20), 3);
}

TEST(WriteViewPly, KeepsEveryPointOverManyBuffers) {
  std::vector<Vec3> cells;
  for (int i = 0; i < 70001; ++i) cells.push_back({static_cast<double>(i), 0, 1});
  std::string bytes;
  const auto sink = memory_sink("view.ply", bytes);
  ASSERT_TRUE(write_view_ply(cells, {}, *sink).ok());
  ASSERT_TRUE(sink->commit().ok());
  const std::size_t start = bytes.find("end_header\n") + 11;
  ASSERT_EQ(bytes.size(), start + 12 * cells.size());
  for (std::size_t i = 0; i < cells.size(); ++i)
    ASSERT_EQ(value_at<float>(bytes, start + 12 * i), static_cast<float>(i));
}

}  // namespace
}  // namespace scanmill::exporting
