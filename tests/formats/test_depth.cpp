// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "formats/png.hpp"
#include "hand_made.hpp"

namespace scanmill::formats {
namespace {

std::string big(std::uint32_t value) {
  std::string bytes;
  for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(value >> shift);
  return bytes;
}

/// CRC-32 bit by bit.
std::uint32_t checksum(const std::string& bytes) {
  std::uint32_t crc = 0xffffffffu;
  for (const char c : bytes) {
    crc ^= static_cast<unsigned char>(c);
    for (int bit = 0; bit < 8; ++bit) crc = crc & 1 ? crc >> 1 ^ 0xedb88320u : crc >> 1;
  }
  return ~crc;
}

std::string chunk(const std::string& type, const std::string& body) {
  return big(static_cast<std::uint32_t>(body.size())) + type + body + big(checksum(type + body));
}

/// A zlib stream of stored blocks.
std::string stored(const std::string& bytes) {
  std::string out = "\x78\x01";
  std::uint32_t a = 1, b = 0;
  for (const char c : bytes) {
    a = (a + static_cast<unsigned char>(c)) % 65521;
    b = (b + a) % 65521;
  }
  for (std::size_t at = 0; at == 0 || at < bytes.size(); at += 65535) {
    const std::string block = bytes.substr(at, 65535);
    out += at + 65535 >= bytes.size() ? '\1' : '\0';
    out += raw(static_cast<std::uint16_t>(block.size())) + raw(static_cast<std::uint16_t>(~block.size())) + block;
  }
  return out + big(b << 16 | a);
}

std::string ihdr(std::uint32_t width, std::uint32_t height, int depth = 16, int colour = 0, int interlace = 0) {
  return chunk(
      "IHDR", big(width) + big(height) +
                  std::string{static_cast<char>(depth), static_cast<char>(colour), 0, 0, static_cast<char>(interlace)});
}

const std::string kSignature = "\x89PNG\r\n\x1a\n";
const std::string kEnd = chunk("IEND", "");

/// Rows of filtered bytes, each with its filter; the data in two chunks.
std::string png(std::uint32_t width, std::uint32_t height, const std::string& filtered) {
  const std::string data = stored(filtered);
  return kSignature + ihdr(width, height) + chunk("tEXt", "who\0me") + chunk("IDAT", data.substr(0, 5)) +
         chunk("IDAT", data.substr(5)) + kEnd;
}

std::string pixels(std::initializer_list<int> values) {
  std::string bytes;
  for (const int value : values) bytes += {static_cast<char>(value >> 8), static_cast<char>(value)};
  return bytes;
}

const OpenOptions kCamera{Format::Auto, DepthCamera{2, 4, 1, 0.5, 100}};
const std::string kSmall = png(2, 2, '\0' + pixels({200, 0}) + '\0' + pixels({1000, 65535}));

std::string error_of(const std::string& bytes, const OpenOptions& options = kCamera) {
  const auto scans = read_scans("a.png", bytes, options);
  return scans.ok() ? "no error" : scans.error().text();
}

TEST(ReadDepthMap, PlacesPixelsByTheCamera) {
  const auto scans = read_scans("a.png", kSmall, kCamera);
  ASSERT_TRUE(scans.ok()) << scans.error().text();
  const Whole& whole = scans->front();
  EXPECT_EQ(whole.header.row_meaning, RowMeaning::PixelFromZero);
  EXPECT_EQ(*whole.header.view_point.eye, (Vec3{0, 0, 0}));
  EXPECT_EQ(whole.points_read, 4u);
  EXPECT_EQ(whole.sensor_invalid, 1u);
  EXPECT_EQ(whole.rows, (std::vector<std::uint64_t>{0, 2, 3}));
  EXPECT_EQ(whole.positions[0], (Vec3{-1, -0.25, 2}));
  EXPECT_EQ(whole.positions[1], (Vec3{-5, 1.25, 10}));
  EXPECT_EQ(whole.positions[2].z, 655.35);
}

TEST(ReadDepthMap, UndoesEveryFilter) {
  // The same two rows of values, written with each filter by hand: 0x0102 0x0304 over 0x0506 0x070a.
  const std::string above = '\0' + pixels({0x0102, 0x0304});
  const std::pair<int, std::string> rows[] = {{0, pixels({0x0506, 0x070a})},
                                              {1, pixels({0x0506, 0x0204})},
                                              {2, pixels({0x0404, 0x0406})},
                                              {3, std::string("\x05\x05\x03\x05")},
                                              {4, std::string("\x04\x04\x02\x04")}};
  for (const auto& [filter, row] : rows) {
    const auto source = memory_source("a.png", png(2, 2, above + static_cast<char>(filter) + row));
    const auto file = open_png(*source);
    ASSERT_TRUE(file.ok()) << file.error().text();
    std::vector<std::uint16_t> values;
    const auto read = read_png(*source, *file, values);
    ASSERT_TRUE(read.ok()) << read.error().text();
    EXPECT_EQ(values, (std::vector<std::uint16_t>{0x0102, 0x0304, 0x0506, 0x070a})) << filter;
  }
}

TEST(ReadDepthMap, BlocksOfALargeImageJoin) {
  std::string filtered;
  for (int v = 0; v < 300; ++v) {
    filtered += '\0';
    for (int u = 0; u < 400; ++u) filtered += pixels({v * 400 + u == 77 ? 0 : (v * 7 + u) % 60000 + 1});
  }
  const auto reader =
      open_view(std::shared_ptr<const ByteSource>(memory_source("a.png", png(400, 300, filtered))), kCamera);
  ASSERT_TRUE(reader.ok()) << reader.error().text();
  EXPECT_EQ((*reader)->block_count(), 2u);
  const auto whole = read_whole(**reader);
  ASSERT_TRUE(whole.ok()) << whole.error().text();
  ASSERT_EQ(whole->rows.size(), 119999u);
  for (std::size_t k = 0; k < whole->rows.size(); ++k) {
    const int v = static_cast<int>(whole->rows[k] / 400), u = static_cast<int>(whole->rows[k] % 400);
    ASSERT_EQ(whole->positions[k].z, ((v * 7 + u) % 60000 + 1) / 100.0);
  }
}

TEST(ReadDepthMap, RefusesOtherImagesByName) {
  const std::string data = chunk("IDAT", stored(std::string(100, '\0'))) + kEnd;
  EXPECT_NE(error_of(kSmall, {}).find("needs the numbers of its camera"), std::string::npos);
  EXPECT_NE(error_of(kSignature + ihdr(2, 2, 8) + data).find("has 8 bits per pixel"), std::string::npos);
  EXPECT_NE(error_of(kSignature + ihdr(2, 2, 16, 2) + data).find("is of colour"), std::string::npos);
  EXPECT_NE(error_of(kSignature + ihdr(2, 2, 16, 0, 1) + data).find("is interlaced"), std::string::npos);
  EXPECT_NE(error_of(kSignature + ihdr(0, 2) + data).find("declares 0 x 2 pixels"), std::string::npos);
  EXPECT_NE(error_of(kSignature + ihdr(16000, 16000) + data).find("its 111 compressed bytes cannot hold them"),
            std::string::npos);
  EXPECT_NE(error_of(kSignature + ihdr(4, 4) + chunk("IDAT", stored("a")) + kEnd).find("fewer rows than"),
            std::string::npos);
  EXPECT_NE(error_of(png(2, 1, '\5' + pixels({1, 2}))).find("row 0 of the image names the filter 5"),
            std::string::npos);
}

TEST(ReadDepthMap, BearsCutsAndFindsEveryFlippedByte) {
  expect_bears_cuts("a.png", kSmall, kCamera, kSmall.size());
  expect_bears_damage("a.png", kSmall, kCamera, 1500);
  const std::size_t data = kSmall.find("IDAT") - 4;
  for (std::size_t at = 0; at < kSmall.size(); ++at) {
    std::string bytes = kSmall;
    bytes[at] = static_cast<char>(bytes[at] ^ 1);
    const bool decides = at < 33 || (at >= data && at < kSmall.size() - kEnd.size());
    const auto scans = read_scans("a.png", bytes, kCamera);
    EXPECT_FALSE(decides && scans.ok()) << at;
  }
}

}  // namespace
}  // namespace scanmill::formats
