// SPDX-License-Identifier: Apache-2.0
// A ZIP archive as OPC packages want it: deflated parts, sizes in front of each, no times.
#pragma once
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "base/bytes.hpp"

namespace scanmill::exporting {

/// Tests lower these; files are the same for any `in_memory`.
struct ZipLimits {
  std::uint64_t narrow = 0xfffffffeull;  // greatest size and offset that 32 bits hold; above, the part is ZIP64
  std::size_t in_memory = 64 << 20;      // a compressed part of more is made twice: for its sizes, then for its bytes
};

class ZipWriter {
 public:
  explicit ZipWriter(ByteSink& sink, ZipLimits limits = {}) : sink_(sink), limits_(limits) {}
  /// Adds a part; `fill` writes its bytes, the same ones if it is called again.
  /// errors  Internal when they are not; those of `fill` and the sink
  Result<void> add(const std::string& name, const std::function<Result<void>(ByteSink&)>& fill);
  /// The directory; nothing may be added afterwards, and the sink is not committed.
  Result<void> finish();

 private:
  struct Part {
    std::string name;
    std::uint32_t crc;
    std::uint64_t compressed, size, offset;
    bool wide;  // ZIP64
  };
  ByteSink& sink_;
  ZipLimits limits_;
  std::vector<Part> parts_;
  std::uint64_t written_ = 0;
};

}  // namespace scanmill::exporting
