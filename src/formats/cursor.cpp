// SPDX-License-Identifier: Apache-2.0
#include "formats/cursor.hpp"

#include <algorithm>
#include <cstring>

namespace scanmill::formats {

Result<void> Cursor::refill(std::size_t wanted) {
  const std::size_t kept = at_ < buffer_.size() ? buffer_.size() - at_ : 0;
  if (kept > 0) std::memmove(buffer_.data(), buffer_.data() + at_, kept);
  base_ += at_;
  at_ = 0;
  const std::uint64_t left = source_.size() > base_ + kept ? source_.size() - base_ - kept : 0;
  const std::size_t more = std::min<std::uint64_t>(left, std::max(window_, wanted) - kept);
  buffer_.resize(kept + more);
  return read_exactly(source_, base_ + kept, std::span<char>(buffer_.data() + kept, more));
}

Result<std::string_view> Cursor::peek(std::size_t size) {
  if (at_ + size > buffer_.size()) TRY(refill(size));
  return std::string_view(buffer_.data() + at_, std::min(size, buffer_.size() - at_));
}

void Cursor::skip(std::uint64_t bytes) {
  if (bytes <= buffer_.size() - at_) {
    at_ += static_cast<std::size_t>(bytes);
    return;
  }
  base_ += at_ + bytes;
  at_ = 0;
  buffer_.clear();
}

Result<std::string_view> Cursor::line() {
  std::size_t seen = 0;
  for (;;) {
    const char* begin = buffer_.data() + at_;
    const std::size_t have = buffer_.size() - at_;
    const auto* end = have > seen ? static_cast<const char*>(std::memchr(begin + seen, '\n', have - seen)) : nullptr;
    if (end != nullptr) {
      const auto length = static_cast<std::size_t>(end - begin);
      at_ += length + 1;
      return std::string_view(begin, length);
    }
    if (base_ + buffer_.size() >= source_.size()) {
      at_ = buffer_.size();
      return std::string_view(begin, have);
    }
    if (have > kMaxLine)
      return fail(Code::BadInput, "a line is longer than 1 MiB; this is no text file of points",
                  byte_place(source_.name(), offset()));
    seen = have;
    TRY(refill(have + window_));
  }
}

std::string byte_place(const std::string& name, std::uint64_t offset) {
  return name + ": byte " + std::to_string(offset);
}

std::string line_place(const std::string& name, std::uint64_t line) { return name + ":" + std::to_string(line); }

std::string quoted(std::string_view text) {
  while (!text.empty() && (text.back() == '\r' || text.back() == ' ')) text.remove_suffix(1);
  std::string out = "\"";
  for (const char c : text.substr(0, 40)) out += c >= ' ' && c != 127 ? c : '?';
  return out + (text.size() > 40 ? "...\"" : "\"");
}

Result<void> read_exactly(const ByteSource& source, std::uint64_t offset, std::span<char> out) {
  TRY_ASSIGN(const std::size_t got, source.read_at(offset, out));
  if (got == out.size()) return {};
  return fail(Code::IoFailed, "the file became shorter while it was read; let the copy finish and try again",
              byte_place(source.name(), offset + got));
}

}  // namespace scanmill::formats
