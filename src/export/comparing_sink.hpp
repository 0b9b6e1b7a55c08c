// SPDX-License-Identifier: Apache-2.0
// Reading back: a writer writes once more, and every piece is compared with what the file holds at that place.
#pragma once
#include <algorithm>
#include <vector>

#include "base/bytes.hpp"
#include "base/text.hpp"

namespace scanmill::exporting {

class ComparingSink final : public ByteSink {
 public:
  explicit ComparingSink(const ByteSource& source) : source_(source) {}
  const std::string& name() const override { return source_.name(); }
  using ByteSink::write;
  Result<void> write(std::span<const char> bytes) override {
    found_.resize(std::max(found_.size(), bytes.size()));
    TRY_ASSIGN(const std::size_t got, source_.read_at(offset_, std::span<char>(found_.data(), bytes.size())));
    const auto [wanted, found] =
        std::mismatch(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(got), found_.begin());
    offset_ += static_cast<std::uint64_t>(wanted - bytes.begin());
    if (wanted == bytes.end()) return {};
    if (wanted - bytes.begin() == static_cast<std::ptrdiff_t>(got)) return differs("the file ends too early");
    return differs("the file holds byte value " + std::to_string(static_cast<unsigned char>(*found)) +
                   ", written was " + std::to_string(static_cast<unsigned char>(*wanted)));
  }
  /// After the last write: nothing may stand behind.
  Result<void> commit() override {
    if (source_.size() == offset_) return {};
    return differs(grouped(source_.size() - offset_) + " bytes stand behind what was written");
  }

 private:
  Error differs(const std::string& what) const {
    return fail(Code::Internal, what + "; the file was damaged on its way",
                source_.name() + ": byte " + std::to_string(offset_));
  }
  const ByteSource& source_;
  std::uint64_t offset_ = 0;
  std::vector<char> found_;
};

}  // namespace scanmill::exporting
