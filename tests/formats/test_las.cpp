// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "hand_made.hpp"

namespace scanmill::formats {
namespace {

constexpr std::uint16_t kPointBytes[] = {20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67};

struct LasSample {
  int minor = 2, point_format = 0;
  std::uint16_t extra = 0;   // bytes behind each point
  std::uint32_t points = 3;  // declared
  std::string between = {};  // behind the header
  int withheld = -1;         // which point
};

std::string las(const LasSample& sample) {
  const std::size_t header = sample.minor == 4 ? 375 : 227;
  std::string bytes(header, '\0');
  bytes.replace(0, 4, "LASF");
  bytes[24] = 1;
  bytes[25] = static_cast<char>(sample.minor);
  put<std::uint16_t>(bytes, 94, static_cast<std::uint16_t>(header));
  put<std::uint32_t>(bytes, 96, static_cast<std::uint32_t>(header + sample.between.size()));
  put<std::uint32_t>(bytes, 100, 4000000000u);  // records that are not there: nobody needs them
  bytes[104] = static_cast<char>(sample.point_format);
  const auto stride = static_cast<std::uint16_t>(kPointBytes[sample.point_format] + sample.extra);
  put<std::uint16_t>(bytes, 105, stride);
  put<std::uint32_t>(bytes, 107, sample.minor == 4 ? 0 : sample.points);
  const double numbers[] = {0.5, 0.25, 2, 1000, -5, 0.125};
  for (std::size_t i = 0; i < 6; ++i) put(bytes, 131 + 8 * i, numbers[i]);
  if (sample.minor == 4) put<std::uint64_t>(bytes, 247, sample.points);
  bytes += sample.between;
  for (std::int32_t i = 0; i < 3; ++i) {
    std::string point(stride, '\0');
    put<std::int32_t>(point, 0, 10 * i);
    put<std::int32_t>(point, 4, -i);
    put<std::int32_t>(point, 8, i == 1 ? -2147483648 : 7);
    if (i == sample.withheld) point[15] = static_cast<char>(sample.point_format >= 6 ? 4 : 128);
    bytes += point;
  }
  return bytes;
}

const std::vector<Vec3> kPoints{{1000, -5, 14.125}, {1005, -5.25, -4294967295.875}, {1010, -5.5, 14.125}};

TEST(ReadLas, ReadsEveryVersionAndPointFormat) {
  for (int minor = 0; minor <= 4; ++minor)
    for (int format = 0; format <= 10; ++format) {
      const auto whole = read_whole("a.las", las({minor, format, static_cast<std::uint16_t>(3 * minor), 3, "VLR"}));
      ASSERT_TRUE(whole.ok()) << whole.error().text();
      EXPECT_EQ(whole->positions, kPoints) << minor << " " << format;
      EXPECT_EQ(whole->rows, (std::vector<std::uint64_t>{0, 1, 2}));
      EXPECT_EQ(whole->header.format, "las 1." + std::to_string(minor) + " format " + std::to_string(format));
      EXPECT_EQ(whole->header.row_meaning, RowMeaning::PointFromZero);
    }
}

TEST(ReadLas, DropsWithheldPointsAsInvalid) {
  for (const auto& [minor, format] : {std::pair{2, 1}, {4, 6}}) {
    const auto whole = read_whole("a.las", las({minor, format, 0, 3, "", 1}));
    ASSERT_TRUE(whole.ok()) << whole.error().text();
    EXPECT_EQ(whole->sensor_invalid, 1u);
    EXPECT_EQ(whole->rows, (std::vector<std::uint64_t>{0, 2}));
  }
  EXPECT_EQ(read_whole("a.las", las({0, 1, 0, 3, "", 1}))->sensor_invalid, 0u);  // 1.0 has no such bit
}

TEST(ReadLas, PassesOverTheMarkOfTheFirstVersion) {
  LasSample sample{0, 0, 0, 3, ""};
  std::string bytes = las(sample);
  bytes.insert(227, "\xdd\xcc");
  const auto whole = read_whole("a.las", bytes);
  ASSERT_TRUE(whole.ok()) << whole.error().text();
  EXPECT_EQ(whole->positions, kPoints);
}

TEST(ReadLas, SaysWhatIsWrongAndWhere) {
  auto error = [](std::string bytes, std::size_t at, auto value) {
    put(bytes, at, value);
    const auto whole = read_whole("a.las", bytes);
    return whole.ok() ? "no error" : whole.error().text();
  };
  const std::string old = las({}), now = las({4, 6});
  EXPECT_EQ(error(old, 107, 4u),
            "a.las: byte 287: the header declares 4 points, the file ends after 3; it was cut or "
            "its header is wrong");
  EXPECT_NE(error(now, 247, 1ull << 62).find("declares 4611686018427387904 points, the file ends after 3"),
            std::string::npos);
  EXPECT_NE(error(now, 107, 2u).find("a.las: byte 107: the header declares 3 points in its 64-bit field and 2"),
            std::string::npos);
  EXPECT_NE(error(old, 104, '\x80').find("LAZ"), std::string::npos);
  EXPECT_NE(error(old, 104, '\xb').find("point format 11"), std::string::npos);
  EXPECT_NE(error(old, 105, std::uint16_t{19}).find("points of 19 bytes, point format 0 takes 20"), std::string::npos);
  EXPECT_NE(error(old, 96, 100u).find("points begin at byte 100"), std::string::npos);
  EXPECT_NE(error(old, 131, 0.0).find("byte 131: the scale factors are 0 0.25 2"), std::string::npos);
  EXPECT_NE(error(old, 25, '\5').find("LAS version 1.5"), std::string::npos);
  EXPECT_EQ(error(now, 131, 1e308).substr(0, 8), "no error");  // beyond the range of numbers: dropped, not a crash
  const auto legacy = read_whole("a.las", [&] {
    std::string bytes = now;
    put<std::uint64_t>(bytes, 247, 0);
    put<std::uint32_t>(bytes, 107, 3);
    return bytes;
  }());
  ASSERT_TRUE(legacy.ok());
  EXPECT_EQ(legacy->positions, kPoints);
  EXPECT_EQ(legacy->header.notes.size(), 1u);
}

TEST(ReadLas, BearsCutsAndDamage) {
  for (const std::string& bytes : {las({}), las({4, 7, 2, 3, "record"})}) {
    expect_bears_cuts("a.las", bytes, {}, bytes.size());
    expect_bears_damage("a.las", bytes, {}, 1500);
  }
}

}  // namespace
}  // namespace scanmill::formats
