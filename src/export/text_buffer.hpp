// SPDX-License-Identifier: Apache-2.0
// Text on its way to a sink: shortest numbers, large pieces.
#pragma once
#include <charconv>
#include <cstdlib>
#include <string_view>
#include <vector>

#include "base/bytes.hpp"

namespace scanmill::exporting {

class TextBuffer {
 public:
  explicit TextBuffer(ByteSink& sink) : sink_(sink), bytes_(kBytes + kMargin) {}
  TextBuffer& text(std::string_view text) {
    if (text.size() > bytes_.size() - used_) std::abort();  // a caller that forgot flush_when_full
    text.copy(bytes_.data() + used_, text.size());
    used_ += text.size();
    return *this;
  }
  /// The shortest text that reads back to the same value of its type.
  template <class Number>
  TextBuffer& number(Number value) {
    char* begin = bytes_.data() + used_;
    const auto done = std::to_chars(begin, bytes_.data() + bytes_.size(), value);
    if (done.ec == std::errc{}) used_ = static_cast<std::size_t>(done.ptr - bytes_.data());
    return *this;
  }
  /// Between two calls at most kMargin bytes may be added.
  Result<void> flush_when_full() { return used_ >= kBytes ? flush() : Result<void>{}; }
  Result<void> flush() {
    const std::size_t size = used_;
    used_ = 0;
    return size == 0 ? Result<void>{} : sink_.write(std::span<const char>(bytes_.data(), size));
  }

 private:
  static constexpr std::size_t kBytes = 1 << 18, kMargin = 1 << 12;
  ByteSink& sink_;
  std::vector<char> bytes_;
  std::size_t used_ = 0;
};

}  // namespace scanmill::exporting
