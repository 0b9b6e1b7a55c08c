// SPDX-License-Identifier: Apache-2.0
// A ZIP archive as OPC packages want it: deflated parts, sizes in front of each, no times.
#pragma once
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "base/bytes.hpp"

namespace scanmill::exporting {

class ZipWriter {
 public:
  explicit ZipWriter(ByteSink& sink) : sink_(sink) {}
  /// Adds a part; `fill` writes its bytes. The compressed part is held in memory.
  /// errors  Unsupported for a part of 4 GiB or more; those of `fill` and the sink
  Result<void> add(const std::string& name, const std::function<Result<void>(ByteSink&)>& fill);
  /// The directory; nothing may be added afterwards, and the sink is not committed.
  Result<void> finish();

 private:
  struct Part {
    std::string name;
    std::uint32_t crc, compressed, size, offset;
  };
  ByteSink& sink_;
  std::vector<Part> parts_;
  std::uint64_t written_ = 0;
};

}  // namespace scanmill::exporting
