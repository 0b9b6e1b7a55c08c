// SPDX-License-Identifier: Apache-2.0
// After the PNG specification (W3C, second edition): chunks with a CRC-32, rows with a filter byte, deflate around
// them.
#include "formats/png.hpp"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <memory>
#include <string>

#include "formats/cursor.hpp"

namespace scanmill::formats {
namespace {

constexpr std::uint64_t kMaxPixels = 1ull << 28;
constexpr std::uint64_t kDeflateRatio = 1032;
constexpr std::size_t kHead = 8;  // signature; also length and type of a chunk

std::uint32_t big_endian(const char* p) {
  std::uint32_t value = 0;
  for (int i = 0; i < 4; ++i) value = value << 8 | static_cast<unsigned char>(p[i]);
  return value;
}

Error cut(const ByteSource& source, const std::string& what) {
  return fail(Code::BadInput, "the file ends " + what + "; it was cut", byte_place(source.name(), source.size()));
}

std::uint32_t crc_of(std::uint32_t crc, std::span<const char> bytes) {
  return static_cast<std::uint32_t>(
      crc32(crc, reinterpret_cast<const Bytef*>(bytes.data()), static_cast<uInt>(bytes.size())));
}

Result<void> take_ihdr(const ByteSource& source, std::uint64_t offset, bool is_8_bit_fine, PngFile& file) {
  std::array<char, 21> chunk{};  // type, 13 bytes, checksum
  TRY(read_exactly(source, offset + 4, chunk));
  const std::string place = byte_place(source.name(), offset + 8);
  if (crc_of(0, std::span(chunk).first(17)) != big_endian(chunk.data() + 17))
    return fail(Code::BadInput, "the checksum of the chunk IHDR is wrong; the file is damaged", place);
  const char* const ihdr = chunk.data() + 4;
  file.width = big_endian(ihdr);
  file.height = big_endian(ihdr + 4);
  const int depth = ihdr[8], colour = ihdr[9];
  if (colour != 0)
    return fail(Code::Unsupported,
                std::string("the PNG image is ") +
                    (colour == 3   ? "of palette"
                     : colour == 4 ? "of grey and alpha"
                                   : "of colour") +
                    (is_8_bit_fine ? ", wanted one channel of grey"
                                   : ", a depth map is 16-bit grey; write depths as one 16-bit channel"),
                place);
  file.bits = depth;
  if (depth != 16 && is_8_bit_fine && depth != 8)
    return fail(Code::Unsupported, "the PNG image has " + std::to_string(depth) + " bits per pixel, wanted 8 or 16",
                place);
  if (depth != 16 && !is_8_bit_fine)
    return fail(Code::Unsupported,
                "the PNG image has " + std::to_string(depth) +
                    " bits per pixel, a depth map has 16; 256 steps are too coarse for a surface",
                place);
  if (ihdr[10] != 0 || ihdr[11] != 0 || ihdr[12] < 0 || ihdr[12] > 1)
    return fail(Code::BadInput, "the PNG image names an unknown way of compression, filtering or interlacing", place);
  if (ihdr[12] == 1)
    return fail(Code::Unsupported, "the PNG image is interlaced (Adam7); save it without interlacing", place);
  if (file.width == 0 || file.height == 0 || std::uint64_t{file.width} * file.height > kMaxPixels)
    return fail(Code::BadInput,
                "the PNG image declares " + std::to_string(file.width) + " x " + std::to_string(file.height) +
                    " pixels, wanted 1 to 2^28 in all",
                place);
  return {};
}

/// An inflate stream that ends with its scope.
struct Inflater {
  z_stream stream{};
  bool ready = inflateInit(&stream) == Z_OK;
  Inflater() = default;
  Inflater(const Inflater&) = delete;
  Inflater& operator=(const Inflater&) = delete;
  ~Inflater() { inflateEnd(&stream); }
};

unsigned char paeth(int left, int up, int corner) {
  const int guess = left + up - corner;
  const int a = std::abs(guess - left), b = std::abs(guess - up), c = std::abs(guess - corner);
  return static_cast<unsigned char>(a <= b && a <= c ? left : b <= c ? up : corner);
}

/// Undoes the filter of one row of pixels of `back` bytes; `above` is the finished row before, zeros for the first.
bool unfilter(int filter, std::size_t back, std::span<unsigned char> row, std::span<const unsigned char> above) {
  if (filter > 4) return false;
  for (std::size_t i = 0; filter != 0 && i < row.size(); ++i) {
    const int left = i >= back ? row[i - back] : 0, up = above[i], corner = i >= back ? above[i - back] : 0;
    const int add = filter == 1 ? left : filter == 2 ? up : filter == 3 ? (left + up) / 2 : paeth(left, up, corner);
    row[i] = static_cast<unsigned char>(row[i] + add);
  }
  return true;
}

/// Feeds the pieces to the inflater; rows come out one by one.
class Rows {
 public:
  Rows(const ByteSource& source, const PngFile& file) : source_(source), file_(file) {}

  /// Fills `out` whole.
  Result<void> next(std::span<unsigned char> out) {
    z_stream& z = inflater_.stream;
    if (!inflater_.ready) return fail(Code::NoSpace, "no memory to decompress the image", source_.name());
    z.next_out = out.data();
    z.avail_out = static_cast<uInt>(out.size());
    while (z.avail_out > 0) {
      if (z.avail_in == 0) {
        if (piece_ == file_.pieces.size()) return too_short();
        TRY(load());
      }
      const int state = inflate(&z, Z_NO_FLUSH);
      if (state == Z_STREAM_END && z.avail_out > 0) return too_short();
      if (state != Z_OK && state != Z_STREAM_END && !(state == Z_BUF_ERROR && z.avail_in == 0))
        return fail(Code::BadInput,
                    std::string("the compressed image is broken") + (z.msg != nullptr ? std::string(": ") + z.msg : ""),
                    byte_place(source_.name(), file_.pieces[piece_ - 1].first));
    }
    return {};
  }

  /// The checksums of the pieces that no row asked for.
  Result<void> finish() {
    while (piece_ < file_.pieces.size()) TRY(load());
    return {};
  }

 private:
  Error too_short() const {
    return fail(Code::BadInput, "the compressed data holds fewer rows than the image declares; the file is damaged",
                source_.name());
  }

  Result<void> load() {
    const auto [offset, size] = file_.pieces[piece_++];
    bytes_.resize(std::size_t{size} + 8);  // type, data, checksum
    TRY(read_exactly(source_, offset - 4, bytes_));
    if (crc_of(0, std::span(bytes_).first(std::size_t{size} + 4)) != big_endian(bytes_.data() + 4 + size))
      return fail(Code::BadInput, "the checksum of a chunk IDAT is wrong; the file is damaged",
                  byte_place(source_.name(), offset));
    inflater_.stream.next_in = reinterpret_cast<Bytef*>(bytes_.data() + 4);
    inflater_.stream.avail_in = size;
    return {};
  }

  const ByteSource& source_;
  const PngFile& file_;
  Inflater inflater_;
  std::size_t piece_ = 0;
  std::vector<char> bytes_;
};

}  // namespace

Result<PngFile> open_png(const ByteSource& source, bool is_8_bit_fine) {
  PngFile file;
  std::array<char, kHead> head{};
  if (source.size() < kHead) return cut(source, "within its signature");
  TRY(read_exactly(source, 0, head));
  if (head != std::array<char, kHead>{'\x89', 'P', 'N', 'G', '\r', '\n', '\x1a', '\n'})
    return fail(Code::BadInput, "found no PNG signature; the file is no PNG image or was changed as text",
                byte_place(source.name(), 0));
  std::uint64_t packed = 0;
  for (std::uint64_t at = kHead;;) {
    if (source.size() - at < 12) return cut(source, "before the chunk IEND");
    TRY(read_exactly(source, at, head));
    const std::uint32_t size = big_endian(head.data());
    const std::string type(head.data() + 4, 4);
    if (size > source.size() - at - 12) return cut(source, "within the chunk " + quoted(type));
    if (at == kHead) {
      if (type != "IHDR" || size != 13)
        return fail(Code::BadInput, "found the chunk " + quoted(type) + ", wanted IHDR first",
                    byte_place(source.name(), at));
      TRY(take_ihdr(source, at, is_8_bit_fine, file));
    }
    if (type == "IEND") break;
    if (type == "IDAT" && size > 0) {
      file.pieces.emplace_back(at + 8, size);
      packed += size;
    }
    at += 12 + std::uint64_t{size};
  }
  const std::uint64_t bytes = std::uint64_t{file.height} * (1 + (file.bits == 16 ? 2 : 1) * std::uint64_t{file.width});
  if (bytes > packed * kDeflateRatio + 64)
    return fail(Code::BadInput,
                "the image declares " + std::to_string(file.width) + " x " + std::to_string(file.height) +
                    " pixels, its " + std::to_string(packed) + " compressed bytes cannot hold them",
                byte_place(source.name(), 16));
  return file;
}

Result<void> read_png(const ByteSource& source, const PngFile& file, std::vector<std::uint16_t>& pixels) {
  const std::size_t step = file.bits == 16 ? 2 : 1, width = file.width, row_bytes = step * width;
  pixels.resize(width * file.height);
  std::vector<unsigned char> above(row_bytes), row(row_bytes + 1);
  Rows rows(source, file);
  for (std::size_t y = 0; y < file.height; ++y) {
    TRY(rows.next(row));
    if (!unfilter(row[0], step, std::span(row).subspan(1), above))
      return fail(Code::BadInput,
                  "row " + std::to_string(y) + " of the image names the filter " + std::to_string(row[0]) +
                      ", wanted 0 to 4; the file is damaged",
                  source.name());
    for (std::size_t x = 0; x < width; ++x)
      pixels[y * width + x] = step == 1 ? row[1 + x] : static_cast<std::uint16_t>(row[1 + 2 * x] << 8 | row[2 + 2 * x]);
    std::copy(row.begin() + 1, row.end(), above.begin());
  }
  return rows.finish();
}

}  // namespace scanmill::formats
