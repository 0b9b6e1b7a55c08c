// SPDX-License-Identifier: Apache-2.0
#include "base/deflate.hpp"

#include <zlib.h>

#include <algorithm>
#include <array>

namespace scanmill {
namespace {

constexpr int kWindowBits = 15, kMemoryLevel = 8;
constexpr std::size_t kAtOnce = std::size_t{1} << 30;  // counts of zlib have 32 bits

Bytef* bytes_of(const char* text) { return reinterpret_cast<Bytef*>(const_cast<char*>(text)); }

}  // namespace

struct Deflater::Stream {
  z_stream z{};
  bool ready = false;
  Stream() = default;
  Stream(const Stream&) = delete;
  Stream& operator=(const Stream&) = delete;
  ~Stream() {
    if (ready) deflateEnd(&z);
  }
  Result<void> run(std::span<const char> bytes, int flush, std::string& out) {
    std::array<char, 1 << 16> piece;
    z.next_in = bytes_of(bytes.data());
    z.avail_in = static_cast<uInt>(bytes.size());
    do {
      z.next_out = bytes_of(piece.data());
      z.avail_out = static_cast<uInt>(piece.size());
      const int state = deflate(&z, flush);
      if (state == Z_STREAM_ERROR)
        return fail(Code::Internal, "zlib could not compress (code " + std::to_string(state) + ")");
      out.append(piece.data(), piece.size() - z.avail_out);
    } while (z.avail_out == 0);
    return {};
  }
};

Deflater::Deflater(std::unique_ptr<Stream> stream) : stream_(std::move(stream)) {}
Deflater::Deflater(Deflater&&) noexcept = default;
Deflater& Deflater::operator=(Deflater&&) noexcept = default;
Deflater::~Deflater() = default;

Result<Deflater> Deflater::begin(Wrapping wrapping, int level, Strategy strategy) {
  auto stream = std::make_unique<Stream>();
  const int bits = wrapping == Wrapping::Zlib ? kWindowBits : -kWindowBits;
  const int state = deflateInit2(&stream->z, level, Z_DEFLATED, bits, kMemoryLevel,
                                 strategy == Strategy::Runs ? Z_RLE : Z_DEFAULT_STRATEGY);
  if (state != Z_OK)
    return fail(state == Z_MEM_ERROR ? Code::NoSpace : Code::Internal,
                "zlib could not begin to compress (code " + std::to_string(state) + ")");
  stream->ready = true;
  return Deflater(std::move(stream));
}

Result<void> Deflater::add(std::span<const char> bytes, std::string& out) {
  for (std::size_t at = 0; at < bytes.size(); at += kAtOnce)
    TRY(stream_->run(bytes.subspan(at, std::min(kAtOnce, bytes.size() - at)), Z_NO_FLUSH, out));
  return {};
}

Result<void> Deflater::finish(std::string& out) { return stream_->run({}, Z_FINISH, out); }

std::uint32_t crc32_of(std::uint32_t before, std::span<const char> bytes) {
  uLong crc = before;
  for (std::size_t at = 0; at < bytes.size(); at += kAtOnce)
    crc = crc32(crc, bytes_of(bytes.data() + at), static_cast<uInt>(std::min(kAtOnce, bytes.size() - at)));
  return static_cast<std::uint32_t>(crc);
}

}  // namespace scanmill
