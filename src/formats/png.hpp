// SPDX-License-Identifier: Apache-2.0
// Reading grey PNG images: 16 bits (depth maps), 8 bits too where the caller can do with them (fringes). The only file
// that includes zlib is png.cpp.
#pragma once
#include <cstdint>
#include <utility>
#include <vector>

#include "base/bytes.hpp"

namespace scanmill::formats {

struct PngFile {
  std::uint32_t width = 0, height = 0;
  int bits = 16;
  std::vector<std::pair<std::uint64_t, std::uint32_t>> pieces;  // of the compressed data: offset, bytes
};

/// Walks over the chunks; reads nothing but their heads and IHDR. An image that the compressed bytes cannot hold
/// (deflate gives at most 1032:1) is refused here, before anything of its size is allocated.
/// errors  BadInput with "file: byte N" for a file that is cut or broken; Unsupported, by name, for 8-bit, colour,
///         palette and interlaced images
Result<PngFile> open_png(const ByteSource& source, bool is_8_bit_fine = false);

/// All pixels, row by row from the top left.
/// errors  BadInput naming the chunk whose checksum is wrong, data that ends too early or a filter that does not exist
Result<void> read_png(const ByteSource& source, const PngFile& file, std::vector<std::uint16_t>& pixels);

}  // namespace scanmill::formats
