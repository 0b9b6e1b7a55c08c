// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <limits>

#include "export/grey_png.hpp"
#include "export/range_maps.hpp"
#include "formats/png.hpp"
#include "formats/view_reader.hpp"

namespace scanmill::exporting {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// 4 x 3 cells, some empty; a pinhole of 100 pixels.
std::vector<Vec3> cells() {
  std::vector<Vec3> points;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column) {
      const double z = static_cast<float>(150.1 + 0.3 * row - 0.7 * column);
      const Vec3 p{static_cast<float>((column - 1.5) * z / 100), static_cast<float>((row - 1) * z / 100), z};
      points.push_back(row == 1 && column > 1 ? Vec3{kNaN, kNaN, kNaN} : p);
    }
  return points;
}

std::string bytes_of(RangeFormat format, const std::vector<Vec3>& points, double scale = 1) {
  std::string bytes;
  const auto sink = memory_sink("view", bytes);
  const std::vector<std::string> comments{"line\nbreak"};
  EXPECT_TRUE(write_range_map(format, {4, 3, points, scale}, comments, *sink).ok());
  EXPECT_TRUE(sink->commit().ok());
  return bytes;
}

PointBlock read_back(std::string bytes, const std::string& name, const formats::OpenOptions& options = {}) {
  const auto reader = formats::open_view(memory_source(name, std::move(bytes)), options).value();
  PointBlock block;
  EXPECT_EQ(reader->block_count(), 1u);
  EXPECT_TRUE(reader->read_block(0, block).ok());
  return block;
}

TEST(RangeMaps, AreReadBackInEveryFormat) {
  const std::vector<Vec3> points = cells();
  std::vector<Vec3> measured;
  for (const Vec3& p : points)
    if (is_finite(p)) measured.push_back(p);
  for (const std::string_view word : {"ply", "xyz", "pcd", "ptx"}) {
    const PointBlock block = read_back(bytes_of(*range_format_of(word), points), "view." + std::string(word));
    ASSERT_EQ(block.positions.size(), measured.size()) << word;
    for (const Vec3& wanted : measured) {
      bool found = false;  // PTX goes column by column
      for (const Vec3& p : block.positions)
        found |= static_cast<float>(p.x) == wanted.x && static_cast<float>(p.y) == wanted.y &&
                 static_cast<float>(p.z) == wanted.z;
      EXPECT_TRUE(found) << word;
    }
  }
  EXPECT_EQ(read_back(bytes_of(RangeFormat::Ptx, points), "view.ptx").sensor_invalid, 2u);
  EXPECT_FALSE(range_format_of("stl"));
}

TEST(RangeMaps, DepthsAreRightToHalfAStep) {
  const std::vector<Vec3> points = cells();
  formats::OpenOptions options;
  options.camera = formats::DepthCamera{100, 100, 1.5, 1, 400};
  const PointBlock block = read_back(bytes_of(RangeFormat::Png, points, 400), "view.png", options);
  ASSERT_EQ(block.positions.size(), 10u);
  for (std::size_t i = 0; i < 10; ++i) {
    const Vec3 wanted = points[static_cast<std::size_t>(block.rows[i])];
    EXPECT_LE(norm(block.positions[i] - wanted), 0.5 / 400 * 1.01);
  }
  std::string bytes;
  const auto sink = memory_sink("view", bytes);
  const auto tooFar = write_range_map(RangeFormat::Png, {4, 3, points, 1000}, {}, *sink);
  ASSERT_FALSE(tooFar.ok());
  EXPECT_NE(tooFar.error().message.find("does not fit into 16 bits"), std::string::npos);
}

TEST(GreyPng, HoldsEveryValueOf8And16Bits) {
  for (const int bits : {8, 16}) {
    std::vector<std::uint16_t> pixels;
    for (std::uint32_t i = 0; i < 70 * 37; ++i)
      pixels.push_back(static_cast<std::uint16_t>(bits == 16 ? i * 2654435761u >> 16 : (i * 7) % 256));
    std::string bytes;
    const auto sink = memory_sink("grey", bytes);
    ASSERT_TRUE(write_grey_png(pixels, 70, bits, *sink).ok());
    ASSERT_TRUE(sink->commit().ok());
    const auto source = memory_source("grey.png", bytes);
    EXPECT_EQ(formats::open_png(*source).ok(), bits == 16);  // depth maps have 16
    const auto file = formats::open_png(*source, true).value();
    EXPECT_EQ(file.width, 70u);
    EXPECT_EQ(file.height, 37u);
    EXPECT_EQ(file.bits, bits);
    std::vector<std::uint16_t> back;
    ASSERT_TRUE(formats::read_png(*source, file, back).ok());
    EXPECT_EQ(back, pixels);
  }
  std::string bytes;
  const auto sink = memory_sink("grey", bytes);
  EXPECT_FALSE(write_grey_png(std::vector<std::uint16_t>(7), 3, 8, *sink).ok());
}

}  // namespace
}  // namespace scanmill::exporting
