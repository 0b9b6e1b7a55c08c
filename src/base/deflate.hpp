// SPDX-License-Identifier: Apache-2.0
// Deflate (RFC 1951), bare or in a zlib stream (RFC 1950), and the checksum of PNG and ZIP.
#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "base/result.hpp"

namespace scanmill {

enum class Wrapping { Zlib, None };
enum class Strategy { Matches, Runs };

/// Compresses what is added, in order. The bytes depend on the input, the level and the zlib library, not on the pieces
/// that the input comes in as long as each is larger than a window or all come at once.
class Deflater {
 public:
  /// Runs: a byte that repeats is all that is looked for, which is twice as fast.
  /// errors  NoSpace
  static Result<Deflater> begin(Wrapping wrapping, int level, Strategy strategy = Strategy::Matches);
  Deflater(Deflater&&) noexcept;
  Deflater& operator=(Deflater&&) noexcept;
  ~Deflater();
  /// Appends to `out` what is ready.
  /// errors  Internal when the library fails
  Result<void> add(std::span<const char> bytes, std::string& out);
  Result<void> finish(std::string& out);

 private:
  struct Stream;
  explicit Deflater(std::unique_ptr<Stream> stream);
  std::unique_ptr<Stream> stream_;
};

/// CRC-32 of what had the checksum `before` (0 at first), continued by `bytes`.
std::uint32_t crc32_of(std::uint32_t before, std::span<const char> bytes);

}  // namespace scanmill
