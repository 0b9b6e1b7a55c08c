// SPDX-License-Identifier: Apache-2.0
// The PNG bytes read back by a reader that shares nothing with the writer.
#include <gtest/gtest.h>
#include <zlib.h>

#include "render/png.hpp"
#include "scenes.hpp"

namespace scanmill::render {
namespace {

std::uint32_t u32(const std::string& s, std::size_t at) {
  std::uint32_t v = 0;
  for (std::size_t k = 0; k < 4; ++k) v = v << 8 | static_cast<unsigned char>(s[at + k]);
  return v;
}

/// Decoded picture; empty when anything is against the format.
Image decoded(const std::string& png) {
  Image image;
  if (png.substr(0, 8) != std::string("\x89PNG\r\n\x1a\n", 8)) return {};
  std::string packed, order;
  for (std::size_t at = 8; at < png.size();) {
    const std::size_t size = u32(png, at);
    const std::string type = png.substr(at + 4, 4), body = png.substr(at + 8, size);
    const auto crc = crc32(0, reinterpret_cast<const Bytef*>(png.data()) + at + 4, static_cast<uInt>(size + 4));
    if (crc != u32(png, at + 8 + size)) return {};
    order += type + " ";
    if (type == "IHDR") {
      image = Image(static_cast<int>(u32(body, 0)), static_cast<int>(u32(body, 4)), {});
      if (body.substr(8) != std::string("\x08\x02\x00\x00\x00", 5)) return {};
    }
    if (type == "IDAT") packed += body;
    at += 12 + size;
  }
  if (order != "IHDR IDAT IEND ") return {};
  const std::size_t row = static_cast<std::size_t>(image.width) * 3;
  std::vector<std::uint8_t> raw((row + 1) * static_cast<std::size_t>(image.height));
  uLongf size = raw.size();
  if (uncompress(raw.data(), &size, reinterpret_cast<const Bytef*>(packed.data()), packed.size()) != Z_OK ||
      size != raw.size())
    return {};
  for (std::size_t y = 0; y < static_cast<std::size_t>(image.height); ++y)
    for (std::size_t i = 0; i < row; ++i) {
      const int left = i >= 3 ? image.rgb[y * row + i - 3] : 0, up = y > 0 ? image.rgb[(y - 1) * row + i] : 0;
      const int filter = raw[y * (row + 1)];
      const int add = filter == 0 ? 0 : filter == 1 ? left : filter == 2 ? up : -1000;
      image.rgb[y * row + i] = static_cast<std::uint8_t>(raw[y * (row + 1) + 1 + i] + add);
    }
  return image;
}

std::string png_of(const Image& image) {
  std::string bytes;
  auto sink = memory_sink("a.png", bytes);
  EXPECT_TRUE(write_png(image, *sink).ok());
  EXPECT_TRUE(sink->commit().ok());
  return bytes;
}

TEST(WritePng, ReadsBackTheSamePixels) {
  for (const auto& [w, h] : {std::pair{1, 1}, {7, 3}, {300, 1}, {1, 300}, {257, 129}}) {
    Image noise(w, h, {});
    Random random(7, static_cast<std::uint64_t>(w), 0);
    for (auto& byte : noise.rgb) byte = static_cast<std::uint8_t>(random.next());
    EXPECT_EQ(decoded(png_of(noise)), noise) << w << "x" << h;
    Image slope(w, h, {});
    for (int y = 0; y < h; ++y)
      for (int x = 0; x < w; ++x) slope.at(x, y)[1] = static_cast<std::uint8_t>(x + 2 * y);
    EXPECT_EQ(decoded(png_of(slope)), slope) << w << "x" << h;
  }
}

TEST(WritePng, ReadsBackARenderedPart) {
  const Mesh mesh = bumpy_sheet(20, 3);
  const auto image = render({&mesh, {}, {}, {}, {}}, {}, Workers().context());
  ASSERT_TRUE(image.ok());
  const std::string bytes = png_of(*image);
  EXPECT_EQ(decoded(bytes), *image);
  EXPECT_EQ(bytes, png_of(*image));
  EXPECT_LT(bytes.size(), image->rgb.size() / 8);
}

TEST(WritePng, RefusesAPictureWithoutPixels) {
  std::string bytes;
  auto sink = memory_sink("a.png", bytes);
  const auto result = write_png(Image(), *sink);
  ASSERT_FALSE(result.ok());
  EXPECT_EQ(result.error().where, "a.png");
}

}  // namespace
}  // namespace scanmill::render
