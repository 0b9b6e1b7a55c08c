// SPDX-License-Identifier: Apache-2.0
// PNG (ISO/IEC 15948): signature, IHDR, one IDAT with the deflated filtered rows, IEND.
#include "render/png.hpp"

#include <cstdlib>
#include <string>

#include "base/deflate.hpp"

namespace scanmill::render {
namespace {

// A shaded part in 1280x960: level 4 takes 64 ms for 387 kB, 6 takes 166 ms for 364 kB, 1 takes 37 ms for 449 kB.
constexpr int kLevel = 4;
constexpr std::size_t kPixel = 3;

void add_u32(std::string& out, std::uint32_t value) {
  for (int shift = 24; shift >= 0; shift -= 8) out.push_back(static_cast<char>(value >> shift & 0xff));
}

void add_chunk(std::string& out, const char* type, std::string_view body) {
  add_u32(out, static_cast<std::uint32_t>(body.size()));
  const std::size_t start = out.size();
  out.append(type, 4).append(body);
  const std::uint32_t crc = crc32_of(0, std::span<const char>(out.data() + start, body.size() + 4));
  add_u32(out, crc);
}

/// The row less the byte one pixel to the left (filter 1) or the row above (2); returns the sum of magnitudes.
std::uint64_t filter_row(int filter, const std::uint8_t* row, const std::uint8_t* above, std::size_t bytes,
                         std::vector<std::uint8_t>& out) {
  out[0] = static_cast<std::uint8_t>(filter);
  std::uint64_t sum = 0;
  for (std::size_t i = 0; i < bytes; ++i) {
    const int left = i >= kPixel ? row[i - kPixel] : 0, up = above != nullptr ? above[i] : 0;
    const auto value = static_cast<std::uint8_t>(row[i] - (filter == 1 ? left : filter == 2 ? up : 0));
    out[i + 1] = value;
    sum += static_cast<std::uint64_t>(std::abs(static_cast<int>(static_cast<std::int8_t>(value))));
  }
  return sum;
}

std::vector<std::uint8_t> filtered(const Image& image) {
  const std::size_t bytes = static_cast<std::size_t>(image.width) * kPixel;
  std::vector<std::uint8_t> out, trial(bytes + 1), best(bytes + 1);
  out.reserve((bytes + 1) * static_cast<std::size_t>(image.height));
  for (int y = 0; y < image.height; ++y) {
    const std::uint8_t* row = image.at(0, y);
    const std::uint8_t* above = y > 0 ? image.at(0, y - 1) : nullptr;
    std::uint64_t least = filter_row(0, row, above, bytes, best);
    for (int filter = 1; filter <= 2; ++filter) {
      const std::uint64_t sum = filter_row(filter, row, above, bytes, trial);
      if (sum >= least) continue;
      least = sum;
      best.swap(trial);
    }
    out.insert(out.end(), best.begin(), best.end());
  }
  return out;
}

}  // namespace

Result<void> write_png(const Image& image, ByteSink& sink) {
  if (image.width <= 0 || image.height <= 0)
    return fail(Code::BadParameter, "a picture without pixels cannot be written as PNG", sink.name());
  const std::size_t row = static_cast<std::size_t>(image.width) * kPixel + 1;
  if (row * static_cast<std::size_t>(image.height) > 0x7fff0000u)
    return fail(Code::Unsupported, "a picture of more than 2 GB of pixels; choose a smaller width and height",
                sink.name());
  const std::vector<std::uint8_t> raw = filtered(image);
  std::string deflated;
  TRY_ASSIGN(Deflater deflater, Deflater::begin(Wrapping::Zlib, kLevel));
  TRY(deflater.add(std::span<const char>(reinterpret_cast<const char*>(raw.data()), raw.size()), deflated));
  TRY(deflater.finish(deflated));
  std::string out("\x89PNG\r\n\x1a\n", 8), header;
  out.reserve(deflated.size() + 64);
  add_u32(header, static_cast<std::uint32_t>(image.width));
  add_u32(header, static_cast<std::uint32_t>(image.height));
  header.append("\x08\x02\x00\x00\x00", 5);  // 8 bits, RGB, deflate, filters, not interlaced
  add_chunk(out, "IHDR", header);
  add_chunk(out, "IDAT", deflated);
  add_chunk(out, "IEND", {});
  return sink.write(std::string_view(out));
}

}  // namespace scanmill::render
