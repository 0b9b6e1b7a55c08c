// SPDX-License-Identifier: Apache-2.0
// A source read from front to back through a window of fixed size: for headers, index passes and small text files.
#pragma once
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include "base/bytes.hpp"

namespace scanmill::formats {

/// No line of a text file may be longer; a file without line ends would otherwise fill the memory.
constexpr std::size_t kMaxLine = 1 << 20;

class Cursor {
 public:
  explicit Cursor(const ByteSource& source, std::uint64_t offset = 0, std::size_t window = 1 << 18)
      : source_(source), base_(offset), window_(window) {}

  /// Place of the next byte in the source.
  std::uint64_t offset() const { return base_ + at_; }
  bool at_end() const { return offset() >= source_.size(); }
  /// `size` bytes (at most 64 KiB) in one piece without moving on; fewer only at the end of the source.
  Result<std::string_view> peek(std::size_t size);
  /// Moves on, past the window too; the caller has checked that the source is that long.
  void skip(std::uint64_t bytes);
  /// The next line without its '\n'; the view is good until the next call. Not to be called at the end.
  /// errors  BadInput when the line is longer than kMaxLine
  Result<std::string_view> line();
  /// The same where the line lies whole in the window; false (and nothing moves) otherwise. Index passes over millions
  /// of lines would spend half their time on the Result.
  bool line_at_hand(std::string_view& text) {
    if (at_ >= buffer_.size()) return false;
    const char* begin = buffer_.data() + at_;
    const void* end = std::memchr(begin, '\n', buffer_.size() - at_);
    if (end == nullptr) return false;
    const auto length = static_cast<std::size_t>(static_cast<const char*>(end) - begin);
    text = {begin, length};
    at_ += length + 1;
    return true;
  }

 private:
  Result<void> refill(std::size_t wanted);

  const ByteSource& source_;
  std::uint64_t base_;  // place of buffer_[0] in the source
  std::size_t window_;
  std::size_t at_ = 0;
  std::vector<char> buffer_;
};

/// "file: byte N"
std::string byte_place(const std::string& name, std::uint64_t offset);
/// "file:N"
std::string line_place(const std::string& name, std::uint64_t line);
/// A piece of a file for a message: at most 40 bytes, what cannot be printed as '?'.
std::string quoted(std::string_view text);
/// Exactly out.size() bytes; IoFailed when the source has become shorter since it was opened.
Result<void> read_exactly(const ByteSource& source, std::uint64_t offset, std::span<char> out);

}  // namespace scanmill::formats
