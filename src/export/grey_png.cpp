// SPDX-License-Identifier: Apache-2.0
// PNG (ISO/IEC 15948): IHDR, one IDAT, IEND. Every row less the row above it (filter 2): depths and fringes change
// little.
#include "export/grey_png.hpp"

#include <algorithm>
#include <string>
#include <string_view>

#include "base/deflate.hpp"

namespace scanmill::exporting {
namespace {

constexpr int kLevel = 4;

void add_u32(std::string& out, std::uint32_t value) {
  for (int shift = 24; shift >= 0; shift -= 8) out.push_back(static_cast<char>(value >> shift & 0xff));
}

void add_chunk(std::string& out, const char* type, std::string_view body) {
  add_u32(out, static_cast<std::uint32_t>(body.size()));
  const std::size_t start = out.size();
  out.append(type, 4).append(body);
  add_u32(out, crc32_of(0, std::span<const char>(out.data() + start, body.size() + 4)));
}

}  // namespace

Result<void> write_grey_png(std::span<const std::uint16_t> pixels, std::uint32_t width, int bits, ByteSink& sink) {
  if (pixels.empty() || width == 0 || pixels.size() % width != 0)
    return fail(Code::BadParameter, "an image of no pixels, or of rows that are not whole, cannot be written",
                sink.name());
  const std::size_t step = bits == 16 ? 2 : 1, row_bytes = width * step;
  std::string raw, row(row_bytes, '\0'), above(row_bytes, '\0');
  raw.reserve((row_bytes + 1) * (pixels.size() / width));
  for (std::size_t begin = 0; begin < pixels.size(); begin += width) {
    for (std::size_t i = 0; i < width; ++i) {
      const std::uint16_t value = bits == 16 ? pixels[begin + i] : std::min<std::uint16_t>(pixels[begin + i], 255);
      if (bits == 16) row[2 * i] = static_cast<char>(value >> 8);
      row[i * step + step - 1] = static_cast<char>(value & 0xff);
    }
    raw.push_back(2);
    for (std::size_t i = 0; i < row_bytes; ++i)
      raw.push_back(static_cast<char>(static_cast<unsigned char>(row[i]) - static_cast<unsigned char>(above[i])));
    above.swap(row);
  }
  std::string deflated, header, out("\x89PNG\r\n\x1a\n", 8);
  TRY_ASSIGN(Deflater deflater, Deflater::begin(Wrapping::Zlib, kLevel));
  TRY(deflater.add(std::span<const char>(raw), deflated));
  TRY(deflater.finish(deflated));
  if (deflated.size() > 0x7fff0000u)
    return fail(Code::Unsupported, "an image of more than 2 GB compressed", sink.name());
  add_u32(header, width);
  add_u32(header, static_cast<std::uint32_t>(pixels.size() / width));
  header.push_back(bits == 16 ? 16 : 8);
  header.append("\x00\x00\x00\x00", 4);  // grey, deflate, filters, not interlaced
  add_chunk(out, "IHDR", header);
  add_chunk(out, "IDAT", deflated);
  add_chunk(out, "IEND", {});
  return sink.write(std::string_view(out));
}

}  // namespace scanmill::exporting
